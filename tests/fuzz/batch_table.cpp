// A batch table: two bytes of how many features, its JSON, a zero byte, its binary part.
// words: streaming/batch_table.cpp streaming/feature_table.cpp
#include "tests/fuzz/table_promises.h"

#include "streaming/batch_table.h"

namespace gnomon::fuzz {

void fuzzOne(Span bytes) {
    if (bytes.size() < 2)
        return;
    const std::uint32_t count =
        std::to_integer<std::uint32_t>(bytes[0]) | std::to_integer<std::uint32_t>(bytes[1]) << 8;
    const Span tables = bytes.subspan(2);
    const Span json = partsOf(tables)[0];
    const Span binary = tables.subspan(std::min(json.size() + 1, tables.size()));
    std::vector<std::string> warnings;
    const auto table = readBatchTable(json, binary, count, warnings);
    demand((count == 0) == (table == nullptr), "there is a table where there are features");
    if (table) {
        demand(table->rows() == count, "a row a feature");
        checkTable(*table);
    }
    for (const std::string& warning : warnings)
        demandReadable(warning);
}

} // namespace gnomon::fuzz
