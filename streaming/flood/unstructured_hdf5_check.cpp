#include "streaming/flood/unstructured_hdf5_check.h"

#include <hdf5.h>

#include <malloc.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <fcntl.h>

namespace gnomon {

namespace {

enum Outcome { Sound = 0, Damaged = 1 };

herr_t toAttribute(hid_t object, const char* name, const H5A_info_t*, void*) {
    const hid_t attribute = H5Aopen(object, name, H5P_DEFAULT);
    if (attribute < 0)
        return -1;
    H5Aclose(attribute);
    return 0;
}

herr_t toObject(hid_t root, const char* name, const H5O_info_t*, void*) {
    const hid_t object = H5Oopen(root, name, H5P_DEFAULT);
    if (object < 0)
        return -1;
    const herr_t status =
        H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, toAttribute, nullptr);
    H5Oclose(object);
    return status;
}

// In the child: only libhdf5, and away without anything that belongs to the parent.
[[noreturn]] void walk(const char* path) {
    const rlimit none{0, 0};
    constexpr rlim_t kSeconds = 5; // millions of objects take less
    const rlimit time{kSeconds, kSeconds};
    setrlimit(RLIMIT_CORE, &none);
    setrlimit(RLIMIT_CPU, &time);
    alarm(2 * kSeconds);
    const int nowhere = open("/dev/null", O_WRONLY);
    if (nowhere >= 0)
        dup2(nowhere, STDERR_FILENO);
#ifdef M_PERTURB
    mallopt(M_PERTURB, 0xA5); // so that what is freed without having been set is noticed
#endif
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    const bool sound = file >= 0 && H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_NATIVE, toObject,
                                              nullptr, H5O_INFO_BASIC) >= 0;
    _exit(sound ? Sound : Damaged);
}

} // namespace

Failure checkHdf5(const std::string& path) {
    // A thread that was inside libhdf5 at the moment of the fork leaves the child a state that no
    // file is to blame for: only what fails each time is the file's.
    constexpr int kTries = 2;
    int status = 0;
    for (int round = 0; round < kTries; ++round) {
        const pid_t child = fork();
        if (child < 0)
            return Error{path, "cannot be tried out: no process could be started",
                         ErrorKind::Transient};
        if (child == 0)
            walk(path.c_str());
        pid_t ended = 0;
        do
            ended = waitpid(child, &status, 0);
        while (ended < 0 && errno == EINTR);
        if (ended < 0 || (WIFEXITED(status) && WEXITSTATUS(status) == Sound))
            return {};
    }
    if (WIFEXITED(status))
        return Error{path, "is damaged: its HDF5 index cannot be read (cut off, or changed)"};
    return Error{path, "is damaged: libhdf5 does not survive reading its index"};
}

} // namespace gnomon
