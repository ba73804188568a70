// The kinds of bytes that gnomon reads, each with small good files made by code, a reader that
// holds what comes out against what its interface promises, and files that are built to do harm.
#pragma once

#include "tests/streaming/glb_builder.h"

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace gnomon::test {

// What a reader made of some bytes. A refusal is a good end; a lie about what was read is not, and
// ends the process (tests/fuzz/*_promises.h) or is told.
struct Read {
    bool accepted = false;
    std::string refusal; // when not accepted
    std::string broken;  // a promise that was not kept; empty when all were
};

struct Family {
    std::string name;
    std::vector<std::string> good; // every one is accepted
    std::function<Read(const std::string&)> read;
    // Bytes that strangers send: reading them opens nothing. The others are the user's own files.
    bool fromStrangers = true;
    int mutations = 2000; // as many as are read within about a second
    // Cut short anywhere it is refused, but for as many bytes at its end (padding, extensions that
    // may be missing). Unset: text that may be whole earlier, or a format that says so.
    std::optional<std::size_t> mayLack = 0;
};
const std::vector<Family>& families();
const Family& familyOf(const std::string& name);
// Libraries open files once: their plug-ins, a list of locales. A good file of each kind that comes
// from strangers has them do it.
void readOneOfEach();

// Of at most a megabyte each, and built to take far more than that, or for ever.
struct Bomb {
    std::string name;
    const Family* family;
    std::string bytes;
};
const std::vector<Bomb>& bombs();

// A function of the file and the number alone: bytes changed, numbers replaced by those that
// matter, pieces taken out, doubled and put elsewhere.
std::string mutated(const std::string& good, std::uint32_t number);

// Everything a small glTF can have: a texture, colours, features, two nodes, sparse values.
GlbBuilder richGlb();

} // namespace gnomon::test
