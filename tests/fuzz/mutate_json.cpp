#include "tests/fuzz/mutate.h"

#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <vector>

namespace gnomon::fuzz {

namespace {

using Json = nlohmann::json;

void collect(Json& value, std::vector<Json*>& out) {
    constexpr std::size_t kMost = 4096;
    if (out.size() >= kMost)
        return;
    out.push_back(&value);
    if (value.is_structured())
        for (Json& inner : value)
            collect(inner, out);
}

Json oddNumber(const Json& before, Random& random) {
    static const std::array<double, 16> kOdd{0,     -1,    1,          2,          3,          255,
                                             65535, 65536, 2147483647, 4294967295, 4294967296, 1e18,
                                             -1e18, 1e300, -0.0,       0.5};
    if (before.is_number() && !oneIn(random, 3)) {
        const double value = before.get<double>();
        switch (random() % 5) {
        case 0:
            return before.is_number_integer() ? Json(before.get<std::int64_t>() / 2)
                                              : Json(value / 2);
        case 1:
            return before.is_number_integer() && value < 1e9 && value > -1e9
                       ? Json(before.get<std::int64_t>() + 1)
                       : Json(value + 1);
        case 2:
            return before.is_number_integer() && value < 1e9 && value > -1e9
                       ? Json(before.get<std::int64_t>() - 1)
                       : Json(-value);
        case 3:
            return before.is_number_integer() && value < 1e9 && value > -1e9
                       ? Json(before.get<std::int64_t>() * 2)
                       : Json(value * 1000);
        default:
            return -value;
        }
    }
    const double odd = kOdd[random() % kOdd.size()];
    return odd == std::floor(odd) && std::abs(odd) < 1e18 ? Json(std::int64_t(odd)) : Json(odd);
}

Json oddValue(const Json& before, Random& random) {
    switch (random() % 8) {
    case 0:
        return nullptr;
    case 1:
        return Json::array();
    case 2:
        return Json::object();
    case 3:
        return before.is_string() ? Json("") : Json("../a.glb");
    case 4:
        return bool(random() % 2);
    default:
        return oddNumber(before, random);
    }
}

void change(Json& root, Random& random) {
    std::vector<Json*> values;
    collect(root, values);
    Json& value = *values[random() % values.size()];
    const Json other = *values[random() % values.size()]; // a copy: it may hold `value`
    switch (random() % 6) {
    case 0:
        value = other;
        break;
    case 1:
        if (value.is_array() && !value.empty()) {
            const std::size_t i = random() % value.size();
            oneIn(random, 2) ? void(value.erase(i)) : value.push_back(Json(value[i]));
        } else if (value.is_object() && !value.empty()) {
            value.erase(std::next(value.begin(), std::ptrdiff_t(random() % value.size())));
        } else {
            value = oddValue(value, random);
        }
        break;
    case 2:
        if (value.is_array())
            value.push_back(other);
        else if (value.is_object() && other.is_object())
            value.update(other);
        else
            value = oddNumber(value, random);
        break;
    case 3:
        value = oddValue(value, random);
        break;
    default:
        value = value.is_structured() ? Json(value) : oddNumber(value, random);
    }
}

} // namespace

std::string mutatedJson(const std::string& json, std::size_t most, Random& random) {
    if (oneIn(random, 2))
        return mutatedBytes(json, most);
    Json root = Json::parse(json, nullptr, false);
    if (root.is_discarded())
        return mutatedBytes(json, most);
    for (unsigned changes = 1 + random() % 3; changes > 0; --changes)
        change(root, random);
    std::string out = root.dump(-1, ' ', false, Json::error_handler_t::replace);
    return out.size() <= most ? out : mutatedBytes(json, most);
}

} // namespace gnomon::fuzz
