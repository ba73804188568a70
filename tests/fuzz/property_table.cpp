// Property tables: the extension's JSON, a zero byte, then the buffer that its views are cut from,
// 32 bytes each.
// words: streaming/property_table.cpp streaming/property_column.cpp
#include "tests/fuzz/table_promises.h"

#include "streaming/gltf_parts.h"
#include "streaming/property_table.h"

namespace gnomon::fuzz {

void fuzzOne(Span bytes) {
    const Span json = partsOf(bytes)[0];
    const Span buffer = bytes.subspan(std::min(json.size() + 1, bytes.size()));
    PropertyTableReader reader;
    reader.view = [&](std::uint64_t i) -> Result<Span> {
        constexpr std::size_t kEach = 32;
        if (i >= buffer.size() / kEach + 1)
            return Error{"view", "is not there"};
        const Span rest = buffer.subspan(i * kEach);
        return rest.first(std::min(kEach, rest.size()));
    };
    Warnings warnings;
    ByteBudget budget(std::uint64_t(64) << 20);
    for (const auto& table : readPropertyTables(textOf(json), reader, warnings, budget))
        if (table)
            checkTable(*table);
    for (const std::string& warning : warnings.all())
        demandReadable(warning);
}

} // namespace gnomon::fuzz
