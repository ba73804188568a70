#include "bench/streaming_detail.h"

#include "bench/streaming_selection.h"

#include <nlohmann/json.hpp>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace gnomon::bench {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// Started with nothing to read; -1 when it could not be.
pid_t start(std::vector<std::string> arguments, int standardOutput) {
    std::vector<char*> pointers;
    for (std::string& argument : arguments)
        pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, standardOutput, 1);
    pid_t process = -1;
    if (::posix_spawnp(&process, pointers[0], &actions, nullptr, pointers.data(), environ) != 0)
        process = -1;
    posix_spawn_file_actions_destroy(&actions);
    return process;
}

// A web server as long as this lives.
class Server {
  public:
    static Result<std::unique_ptr<Server>> open(const std::string& program,
                                                const std::string& folder) {
        int ends[2];
        if (::pipe2(ends, O_CLOEXEC) != 0)
            return Error{program, "no pipe can be had", ErrorKind::Transient};
        auto server = std::make_unique<Server>();
        server->process_ = start({program, folder}, ends[1]);
        ::close(ends[1]);
        // It says its address in a line, and nothing when it cannot serve.
        for (char c = 0; ::read(ends[0], &c, 1) == 1 && c != '\n';)
            server->url_ += c;
        ::close(ends[0]);
        if (server->process_ < 0 || server->url_.empty())
            return Error{program, "does not serve " + folder, ErrorKind::Input};
        return server;
    }
    ~Server() {
        if (process_ > 0) {
            ::kill(process_, SIGTERM);
            ::waitpid(process_, nullptr, 0);
        }
    }
    const std::string& url() const { return url_; }

  private:
    pid_t process_ = -1;
    std::string url_;
};

Result<DetailRow> captureOnce(const DetailInput& input, const std::string& tileset) {
    const std::string report = (fs::path(input.scratchFolder) / "frame.json").string();
    std::vector<std::string> arguments = {input.gnomon,
                                          "capture",
                                          tileset,
                                          "-o",
                                          (fs::path(input.scratchFolder) / "frame.png").string(),
                                          "--camera",
                                          input.camera,
                                          "--frame-report",
                                          report};
    arguments.insert(arguments.end(), input.options.begin(), input.options.end());
    std::error_code ignored;
    fs::remove(report, ignored);
    const pid_t process = start(std::move(arguments), STDERR_FILENO);
    int status = 0;
    rusage used{};
    if (process < 0 || ::wait4(process, &status, 0, &used) < 0 || status != 0)
        return Error{tileset, "gnomon capture does not make a complete picture of it",
                     ErrorKind::Input};
    std::ifstream file(report);
    const Json json = Json::parse(file, nullptr, false);
    if (json.is_discarded() || !json.value("time_to_full_detail_ms", Json()).is_number())
        return Error{report, "tells of no complete picture", ErrorKind::Input};
    const Json& tiles = json["frames"][0]["tiles"];
    constexpr double kKibibyte = 1024.0, kMegabyte = 1e6;
    return DetailRow{"", json["time_to_full_detail_ms"].get<double>(),
                     tiles["selected"].get<std::uint64_t>(), tiles["loaded"].get<std::uint64_t>(),
                     double(used.ru_maxrss) * kKibibyte / kMegabyte};
}

} // namespace

Result<std::vector<DetailRow>> measureDetail(const DetailInput& input) {
    std::vector<std::string> names = {"files"};
    std::vector<std::string> tilesets = {(fs::path(input.folder) / "tileset.json").string()};
    std::unique_ptr<Server> server;
    if (input.server) {
        auto opened = Server::open(*input.server, input.folder);
        if (!opened)
            return opened.error();
        server = std::move(*opened);
        names.push_back("loopback");
        tilesets.push_back(server->url() + "/tileset.json");
    }
    std::vector<std::vector<DetailRow>> runs(names.size());
    for (int run = 0; run < input.runs; ++run) // in turn, so that all meet the same company
        for (std::size_t i = 0; i < names.size(); ++i) {
            Result<DetailRow> row = captureOnce(input, tilesets[i]);
            if (!row)
                return row.error();
            runs[i].push_back(*row);
        }
    std::vector<DetailRow> rows;
    for (std::size_t i = 0; i < names.size(); ++i) {
        DetailRow row = runs[i].back();
        row.from = names[i];
        std::vector<double> times, peaks;
        for (const DetailRow& one : runs[i]) {
            times.push_back(one.fullDetailMs);
            peaks.push_back(one.peakMegabytes);
        }
        row.fullDetailMs = median(std::move(times));
        row.peakMegabytes = median(std::move(peaks));
        rows.push_back(row);
    }
    return rows;
}

} // namespace gnomon::bench
