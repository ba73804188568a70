// Where bytes come from. A uri is resolved against the document that names it and is never allowed
// to leave what the user named (no `..` above the root, no absolute path, no other scheme).
#pragma once

#include "geo/result.h"

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace gnomon {

using Bytes = std::vector<std::byte>;

class Source {
  public:
    virtual ~Source() = default;
    // `path` is relative to the source's root, with forward slashes, already resolved. May be
    // called from several threads at once.
    virtual Result<Bytes> read(const std::string& path) const = 0;
    // As the user would write it, for messages.
    virtual std::string describe(const std::string& path) const = 0;
};

// Files below one folder. Symbolic links that lead out of it are refused.
std::shared_ptr<const Source> fileSource(const std::string& folder);

// RFC 3986 resolution of `uri` against the document `basePath` (both relative to a source's root):
// percent-decoding, `.` and `..`, query and fragment cut off. An error when it leaves the root.
Result<std::string> resolveUri(const std::string& basePath, const std::string& uri);

} // namespace gnomon
