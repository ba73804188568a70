// Where bytes come from: a folder, memory, the web. A uri is resolved against the document that
// names it. Of files it is never allowed to leave what the user named (no `..` above the root, no
// absolute path, no other scheme); a document from the web may name http and https only.
#pragma once

#include "geo/result.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace gnomon {

using Bytes = std::vector<std::byte>;

class Source {
  public:
    virtual ~Source() = default;
    // `path` is relative to the source's root, with forward slashes, already resolved; of the web
    // it is a whole URL. May be called from several threads at once, and waits for the bytes.
    virtual Result<Bytes> read(const std::string& path) const = 0;
    // As the user would write it, for messages: without tokens.
    virtual std::string describe(const std::string& path) const = 0;

    // Of sources where reading is waiting, not work: how many reads are worth having under way at
    // once. 0: there is no gain, and start() reads at once on the calling thread.
    virtual unsigned readsAtOnce() const { return 0; }
    using ReadId = std::uint64_t;
    using Done = std::function<void(Result<Bytes>)>;
    // `done` is called once, on a thread of the source's own, which it must not hold up.
    virtual ReadId start(const std::string& path, Done done) const;
    // Once this returns, `done` of that read has been called or never will be.
    virtual void cancel(ReadId) const {}
};

// Files below one folder. Symbolic links that lead out of it are refused.
std::shared_ptr<const Source> fileSource(const std::string& folder);

// RFC 3986 resolution of `uri` against the document `basePath`.
// Of files (both relative to a source's root): percent-decoding, `.` and `..`, query and fragment
// cut off; an error when it leaves the root.
// Of the web (`basePath` is an http or https URL): a whole URL with its query, without fragment.
// Another host, an absolute path and `..` are the web's ordinary ways; another scheme is an error,
// as is http named by a document that came by https.
Result<std::string> resolveUri(const std::string& basePath, const std::string& uri);

} // namespace gnomon
