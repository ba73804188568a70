// The options of one command. The library only splits the arguments; every value is read by us, so
// that each mistake is told in the same way. The first mistake is kept.
#pragma once

#include "geo/result.h"

#include <cstdint>
#include <functional>
#include <string>

namespace CLI {
class App;
class Option;
} // namespace CLI

namespace gnomon {

class Command {
  public:
    using Read = std::function<Failure(const std::string&)>;

    // Both must outlive it.
    Command(CLI::App& app, Failure& failure) : app_(app), failure_(failure) {}

    // `value` stands for the value in the help; of an option given twice the last counts.
    CLI::Option* option(const std::string& names, const std::string& value, const std::string& help,
                        Read read);
    // One that may be given several times, each of which counts.
    void repeated(const std::string& name, const std::string& value, const std::string& help,
                  Read read);
    void number(const std::string& name, const std::string& value, const std::string& help,
                double min, double max, std::function<void(double)> set);
    void integer(const std::string& name, const std::string& value, const std::string& help,
                 std::int64_t min, std::int64_t max, std::function<void(std::int64_t)> set);
    CLI::App& app() { return app_; }

  private:
    CLI::App& app_;
    Failure& failure_;
};

// What is wrong with a value, told of the option it was given to.
Failure named(const std::string& option, const Error& error);

} // namespace gnomon
