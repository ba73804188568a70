#include "streaming/terrain/gdal_quiet.h"

#include <gdal_priv.h>

#include <mutex>

namespace gnomon {

void registerGdalDrivers() {
    static std::once_flag once;
    std::call_once(once, [] { GDALAllRegister(); });
}

GdalQuiet::GdalQuiet() {
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
