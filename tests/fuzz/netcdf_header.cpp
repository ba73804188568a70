// The header of NetCDF's classic formats, which is looked through before libnetcdf sees the file.
// That the file it lets through does libnetcdf no harm is not tried here: tests/hostile does.
#include "tests/fuzz/memory_file.h"

#include "streaming/flood/unstructured_netcdf_header.h"

namespace gnomon::fuzz {

void fuzzOne(Span bytes) {
    if (!textOf(bytes).starts_with("CDF"))
        return; // nobody takes it for NetCDF
    const MemoryFile file(bytes);
    if (const Failure failure = checkClassicNetCdf(file.path()))
        demandReadable(*failure);
    else
        demand(bytes.size() >= 32, "what is sound has a header");
}

} // namespace gnomon::fuzz
