#include "streaming/terrain/gdal_quiet.h"

#include <gdal_priv.h>
#include <hdf5.h>

#include <algorithm>
#include <mutex>

namespace gnomon {

namespace {

// Datasets read side by side share GDAL's cache of blocks; it stays small beside --memory.
constexpr GIntBig kMostCacheBytes = GIntBig(24) << 20;

} // namespace

void registerGdalDrivers() {
    static std::once_flag once;
    std::call_once(once, [] {
        GDALAllRegister();
        if (CPLGetConfigOption("GDAL_CACHEMAX", nullptr) == nullptr)
            GDALSetCacheMax64(std::min(GDALGetCacheMax64(), kMostCacheBytes));
    });
}

namespace {

// What NetCDF files are made of prints its errors, thread by thread; NetCDF itself stops that on
// the thread that was the first to open a file.
void silenceHdf5() {
    thread_local bool silent = false;
    if (!silent)
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    silent = true;
}

} // namespace

GdalQuiet::GdalQuiet() {
    silenceHdf5();
    CPLPushErrorHandlerEx(&GdalQuiet::take, &said_);
}

GdalQuiet::~GdalQuiet() {
    CPLPopErrorHandler();
}

std::string GdalQuiet::reason() const {
    constexpr std::size_t kLongest = 300;
    std::string line;
    for (const char c : said_.substr(0, kLongest))
        line += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    return line.empty() ? "GDAL gives no reason" : line;
}

void GdalQuiet::take(CPLErr severity, CPLErrorNum, const char* text) {
    auto& said = *static_cast<std::string*>(CPLGetErrorHandlerUserData());
    if (severity >= CE_Failure && said.empty() && text != nullptr)
        said = text;
}

} // namespace gnomon
