// That README.md tells of every item, and of no test that is not there.
#include "tests/viewer/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <set>

namespace gnomon::test {

namespace {

// "Suite.Name" of all tests there are.
std::set<std::string> testNames() {
    std::set<std::string> names;
    const std::regex test(R"(TEST(?:_F|_P)?\((\w+),\s*(\w+)\))");
    for (const auto& entry :
         std::filesystem::recursive_directory_iterator(GNOMON_SOURCE_DIR "/tests")) {
        if (entry.path().extension() != ".cpp")
            continue;
        const std::string text = contentsOf(entry.path().string());
        for (std::sregex_iterator it(text.begin(), text.end(), test), end; it != end; ++it)
            names.insert((*it)[1].str() + "." + (*it)[2].str());
    }
    return names;
}

// * and … stand for anything; what follows a slash is a kind of bytes.
std::regex patternOf(std::string text) {
    text = text.substr(0, text.find('/'));
    text = std::regex_replace(text, std::regex(R"(\.)"), "\\.");
    return std::regex(std::regex_replace(text, std::regex("\\*|…"), ".*"));
}

} // namespace

TEST(HostileList, TellsOfEveryItemAndOfTestsThatThereAre) {
    const std::string readme = contentsOf(GNOMON_SOURCE_DIR "/tests/hostile/README.md");
    const std::set<std::string> names = testNames();
    ASSERT_GT(names.size(), 500u);
    std::set<int> items;
    const std::regex row(R"(^\| (?:\*\*[^*]+\*\* )?(\d+) [^|]*\|([^|]+)\|$)");
    const std::regex quoted(R"(`([A-Z][^`]*\.[^`]*)`)");
    std::istringstream lines(readme);
    for (std::string line; std::getline(lines, line);) {
        std::smatch found;
        const bool isItem = std::regex_match(line, found, row);
        if (isItem)
            items.insert(std::stoi(found[1]));
        std::size_t tests = 0;
        for (std::sregex_iterator it(line.begin(), line.end(), quoted), end; it != end; ++it) {
            const std::string name = (*it)[1];
            if (name.ends_with(".md"))
                continue;
            const std::regex pattern = patternOf(name);
            const bool known = std::any_of(names.begin(), names.end(), [&](const auto& n) {
                return std::regex_match(n, pattern);
            });
            EXPECT_TRUE(known) << name;
            ++tests;
        }
        EXPECT_TRUE(!isItem || tests > 0) << line;
    }
    for (int item = 1; item <= 40; ++item)
        EXPECT_EQ(items.count(item), item == 17 ? 0u : 1u) << "item " << item;
}

} // namespace gnomon::test
