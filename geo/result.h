// What a function that reads outside bytes gives back: a value, or an error that names the thing it
// is about and the reason. Nothing in gnomon throws across a module boundary; programming errors
// assert.
#pragma once

#include <cassert>
#include <optional>
#include <string>
#include <utility>
#include <variant>

namespace gnomon {

// What the caller may do about it; the command line turns it into its exit code.
enum class ErrorKind {
    Usage,     // the request itself is wrong
    Input,     // these bytes cannot be used, trying again will not help
    Output,    // what was asked for cannot be written
    Transient, // it may work later
};

struct Error {
    std::string subject; // the file, tile or option it is about
    std::string reason;  // why, in one line
    ErrorKind kind = ErrorKind::Input;

    std::string message() const { return subject.empty() ? reason : subject + ": " + reason; }
};

template <class T>
class [[nodiscard]] Result {
  public:
    Result(T value) : state_(std::move(value)) {}
    Result(Error error) : state_(std::move(error)) {}

    explicit operator bool() const { return std::holds_alternative<T>(state_); }
    T& value() & { return checked(); }
    const T& value() const& { return const_cast<Result*>(this)->checked(); }
    T&& value() && { return std::move(checked()); }
    T& operator*() & { return checked(); }
    const T& operator*() const& { return value(); }
    T&& operator*() && { return std::move(checked()); }
    T* operator->() { return &checked(); }
    const T* operator->() const { return &value(); }
    const Error& error() const {
        assert(std::holds_alternative<Error>(state_));
        return *std::get_if<Error>(&state_);
    }

  private:
    T& checked() {
        assert(std::holds_alternative<T>(state_));
        return *std::get_if<T>(&state_);
    }
    std::variant<T, Error> state_;
};

// For work that gives nothing back but can fail: empty means it went well.
using Failure = std::optional<Error>;

} // namespace gnomon
