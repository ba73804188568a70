#include "viewer/option_command.h"

#include "viewer/option_values.h"

#include <CLI/CLI.hpp>

namespace gnomon {

CLI::Option* Command::option(const std::string& names, const std::string& value,
                             const std::string& help, Read read) {
    CLI::Option* added = app_.add_option_function<std::string>(
        names,
        [this, read = std::move(read)](const std::string& text) {
            if (!failure_)
                failure_ = read(text);
        },
        help);
    added->type_name(value)->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    return added;
}

void Command::repeated(const std::string& name, const std::string& value, const std::string& help,
                       Read read) {
    CLI::Option* added = app_.add_option_function<std::vector<std::string>>(
        name,
        [this, read = std::move(read)](const std::vector<std::string>& texts) {
            for (const std::string& text : texts)
                if (!failure_)
                    failure_ = read(text);
        },
        help);
    added->type_name(value)->expected(1)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

void Command::number(const std::string& name, const std::string& value, const std::string& help,
                     double min, double max, std::function<void(double)> set) {
    option(name, value, help,
           [name, min, max, set = std::move(set)](const std::string& text) -> Failure {
               const Result<double> number = parseNumber(name, text, min, max);
               if (!number)
                   return number.error();
               set(*number);
               return {};
           });
}

void Command::integer(const std::string& name, const std::string& value, const std::string& help,
                      std::int64_t min, std::int64_t max, std::function<void(std::int64_t)> set) {
    option(name, value, help,
           [name, min, max, set = std::move(set)](const std::string& text) -> Failure {
               const Result<std::int64_t> number = parseInteger(name, text, min, max);
               if (!number)
                   return number.error();
               set(*number);
               return {};
           });
}

Failure named(const std::string& option, const Error& error) {
    return Error{option, error.subject.empty() ? error.reason : error.subject + " " + error.reason,
                 ErrorKind::Usage};
}

} // namespace gnomon
