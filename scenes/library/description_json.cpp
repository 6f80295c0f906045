#include "description_json.h"

#include <equistream/error.h>
#include <equistream/text.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <unordered_map>
#include <utility>

namespace equistream {

namespace {

/// Far beyond the sun's radiance; products of what is within it are finite floats.
constexpr double max_colour = 1e12;

/// Far more than a description needs; keeps every recursion over the tree shallow.
constexpr std::size_t nesting_limit = 32;

/// Each takes some hundred bytes. An hour of a head at 90 keys a second has a third of them.
constexpr std::size_t values_limit = 10'000'000;

/// Feeds the parser and lets the handler know how far it has come.
class CountingCursor {
public:
    using iterator_category = std::input_iterator_tag;
    using value_type = char;
    using difference_type = std::ptrdiff_t;
    using pointer = const char*;
    using reference = const char&;

    CountingCursor(const char* at, std::size_t* characters_read) : at_(at), characters_read_(characters_read) {}
    reference operator*() const { return *at_; }
    CountingCursor& operator++() {
        ++at_;
        ++*characters_read_;
        return *this;
    }
    CountingCursor operator++(int) {
        CountingCursor before = *this;
        ++*this;
        return before;
    }
    bool operator==(const CountingCursor& other) const { return at_ == other.at_; }
    bool operator!=(const CountingCursor& other) const { return at_ != other.at_; }

private:
    const char* at_;
    std::size_t* characters_read_;
};

using Json = nlohmann::json;

/// What a message quotes of text that is not JSON: the string, the word or the sign that it begins with.
std::string quoted_token(std::string_view text) {
    constexpr std::string_view signs = ",:[]{}";
    if (text.empty())
        return "the end of the file";
    if (text.starts_with("//") || text.starts_with("/*") || text.front() == '#')
        return "a comment, which JSON does not have";
    if (text.front() == '"') {
        const std::size_t end = text.find_first_of("\"\n", 1);
        return std::string(text.substr(0, end < text.size() && text[end] == '"' ? end + 1 : end));
    }
    const std::size_t end = signs.find(text.front()) == signs.npos ? text.find_first_of(" \t\r\n\",:[]{}") : 1;
    return "\"" + std::string(text.substr(0, end)) + "\"";
}

class TreeBuilder final : public nlohmann::json_sax<Json> {
public:
    TreeBuilder(std::string_view text, const std::string& file)
        : text_(text), file_(file), behind_(text.starts_with("\xef\xbb\xbf") ? 3 : 0) {}

    std::size_t* characters_read() { return &read_; }
    JsonValue take() { return std::move(root_); }

    bool null() override { return add(JsonValue::Kind::null) != nullptr; }
    bool boolean(bool value) override {
        add(JsonValue::Kind::boolean)->boolean = value;
        return true;
    }
    bool number_integer(number_integer_t value) override { return number(static_cast<double>(value)); }
    bool number_unsigned(number_unsigned_t value) override { return number(static_cast<double>(value)); }
    bool number_float(number_float_t value, const string_t&) override { return number(value); }
    bool string(string_t& value) override {
        add(JsonValue::Kind::text)->text = std::move(value);
        return true;
    }
    bool binary(binary_t&) override { return false; }
    bool start_object(std::size_t) override { return open(JsonValue::Kind::object); }
    bool start_array(std::size_t) override { return open(JsonValue::Kind::array); }
    bool end_object() override { return close(); }
    bool end_array() override { return close(); }

    bool key(string_t& value) override {
        const auto [first, is_new] = keys_.back().emplace(value, line());
        if (!is_new)
            throw InputError(expected_found(place(), "each key once",
                                            "\"" + value + "\" again after line " + std::to_string(first->second)));
        open_.back()->members.push_back({value, line(), {}});
        took(Taken::key);
        return true;
    }

    bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception& e) override {
        constexpr int out_of_range = 406;
        std::size_t at = behind_blanks(behind_);
        auto [expected, may_be_string] = expected_at(at);
        if (e.id == out_of_range)
            expected = "a number that a double can hold";
        else if (may_be_string && at < text_.size() && text_[at] == '"')
            expected = "text in UTF-8 on one line, with JSON's escapes and a quote at its end";
        const std::string_view before = text_.substr(0, at);
        const auto lines = 1 + std::count(before.begin(), before.end(), '\n');
        const std::size_t column = at - (before.rfind('\n') + 1);  // npos + 1 is 0
        throw InputError(expected_found(file_ + ":" + std::to_string(lines) + ":" + std::to_string(column + 1),
                                        expected, quoted_token(text_.substr(at))));
    }

private:
    /// The last thing of which the grammar made something.
    enum class Taken { nothing, opening, key, value };

    void took(Taken what) {
        taken_ = what;
        behind_ = read_;
    }

    std::size_t behind_blanks(std::size_t at) const {
        return std::min(text_.find_first_not_of(" \t\r\n", at), text_.size());
    }

    struct Expected {
        std::string words;
        bool may_be_string = true;
    };

    /// What the grammar asks for at `at`, behind what was taken. A comma or colon where it belongs is passed.
    Expected expected_at(std::size_t& at) const {
        const auto passes = [&](char sign) {
            if (at == text_.size() || text_[at] != sign)
                return false;
            at = behind_blanks(at + 1);
            return true;
        };
        const bool in_object = !open_.empty() && open_.back()->kind == JsonValue::Kind::object;
        switch (taken_) {
        case Taken::opening:
            return {in_object ? "a key in quotes or }" : "a value or ]"};
        case Taken::key:
            if (!passes(':'))
                return {"a colon behind the key", false};
            break;
        case Taken::value:
            if (open_.empty())
                return {"the end of the file", false};
            if (!passes(','))
                return {in_object ? "a comma or }" : "a comma or ]", false};
            if (in_object)
                return {"a key in quotes"};
            break;
        case Taken::nothing:
            break;
        }
        return {"a value"};
    }

    /// The last character read belongs to the token at hand, or (after a number) is the one behind it.
    int line() {
        for (; counted_ + 1 < read_; ++counted_)
            lines_ += text_[counted_] == '\n';
        return lines_;
    }
    std::string place() { return file_ + ":" + std::to_string(line()); }

    bool number(double value) {
        add(JsonValue::Kind::number)->number = value;
        const bool ends_the_text = behind_ == text_.size() && text_.back() >= '0' && text_.back() <= '9';
        behind_ -= ends_the_text ? 0 : 1;  // the character that ended it
        return true;
    }

    JsonValue* add(JsonValue::Kind kind) {
        if (++values_ > values_limit)
            throw InputError(expected_found(place(),
                                            "at most " + std::to_string(values_limit) +
                                                " values in a description (paths may be CSV files beside it)",
                                            "more"));
        JsonValue* value = &root_;
        if (!open_.empty()) {
            JsonValue& parent = *open_.back();
            value =
                parent.kind == JsonValue::Kind::object ? &parent.members.back().value : &parent.items.emplace_back();
        }
        value->kind = kind;
        value->line = line();
        took(Taken::value);
        return value;
    }
    bool open(JsonValue::Kind kind) {
        if (open_.size() == nesting_limit)
            throw InputError(
                expected_found(place(), "at most " + std::to_string(nesting_limit) + " levels of nesting", "more"));
        open_.push_back(add(kind));
        keys_.emplace_back();
        took(Taken::opening);
        return true;
    }
    bool close() {
        open_.pop_back();
        keys_.pop_back();
        took(Taken::value);
        return true;
    }

    std::string_view text_;
    const std::string& file_;
    std::size_t read_ = 0;
    std::size_t counted_ = 0, values_ = 0;
    int lines_ = 1;
    Taken taken_ = Taken::nothing;
    std::size_t behind_;  ///< what was taken; at first a byte order mark
    JsonValue root_;
    /// Pointers stay good: a parent's lists do not grow while a child of it is open.
    std::vector<JsonValue*> open_;
    std::vector<std::unordered_map<std::string, int>> keys_;  ///< of each in open_, with their lines
};

std::string described_list(const std::vector<JsonValue>& items) {
    constexpr std::size_t max_shown = 4;
    const auto is_number = [](const JsonValue& item) { return item.kind == JsonValue::Kind::number; };
    if (items.empty() || items.size() > max_shown || !std::all_of(items.begin(), items.end(), is_number))
        return "a list of " + std::to_string(items.size());
    std::string text;
    for (const JsonValue& item : items)
        text += (text.empty() ? "[" : ", ") + in_words(item.number);
    return text + "]";
}

std::string describe(const JsonValue& value) {
    switch (value.kind) {
    case JsonValue::Kind::null:
        return "null";
    case JsonValue::Kind::boolean:
        return value.boolean ? "true" : "false";
    case JsonValue::Kind::number:
        return Json(value.number).dump();
    case JsonValue::Kind::text:
        return "\"" + value.text.substr(0, 60) + "\"";
    case JsonValue::Kind::array:
        return described_list(value.items);
    case JsonValue::Kind::object:
        break;
    }
    return "an object";
}

std::string joined(std::initializer_list<std::string_view> names) {
    std::string list;
    for (const std::string_view name : names)
        list += (list.empty() ? "" : ", ") + std::string(name);
    return list;
}

}  // namespace

JsonValue parse_json(std::string_view text, const std::string& file) {
    TreeBuilder builder(text, file);
    const CountingCursor begin(text.data(), builder.characters_read());
    const CountingCursor end(text.data() + text.size(), builder.characters_read());
    Json::sax_parse(begin, end, &builder);
    return builder.take();
}

std::string JsonReader::where() const {
    return *file_ + ":" + std::to_string(value_->line);
}

void JsonReader::fail(const std::string& expected) const {
    throw InputError(expected_found(where(), name_.empty() ? expected : expected + " as " + name_, describe(*value_)));
}

double JsonReader::number() const {
    if (value_->kind != JsonValue::Kind::number)
        fail("a number");
    return value_->number;
}

double JsonReader::number_above(double limit) const {
    if (!(number() > limit))
        fail("a number above " + Json(limit).dump());
    return value_->number;
}

double JsonReader::number_within(double least, double most) const {
    if (!(number() >= least && number() <= most))
        fail("a number from " + Json(least).dump() + " to " + Json(most).dump());
    return value_->number;
}

std::string JsonReader::text() const {
    if (value_->kind != JsonValue::Kind::text || value_->text.empty())
        fail("a text");
    return value_->text;
}

std::vector<double> JsonReader::numbers(std::size_t count) const {
    const std::string expected = "a list of " + std::to_string(count) + " numbers";
    if (value_->kind != JsonValue::Kind::array || value_->items.size() != count)
        fail(expected);
    std::vector<double> result;
    for (const JsonReader& item : array())
        result.push_back(item.number());
    return result;
}

glm::dvec3 JsonReader::vector3() const {
    const std::vector<double> n = numbers(3);
    return {n[0], n[1], n[2]};
}

glm::dvec3 JsonReader::colour() const {
    if (value_->kind != JsonValue::Kind::number && value_->kind != JsonValue::Kind::array)
        fail("a number or [r, g, b]");
    const glm::dvec3 c = value_->kind == JsonValue::Kind::number ? glm::dvec3(value_->number) : vector3();
    if (!(c.x >= 0 && c.y >= 0 && c.z >= 0))
        fail("no negative number");
    if (!(c.x <= max_colour && c.y <= max_colour && c.z <= max_colour))
        fail("numbers up to 1e12");
    return c;
}

std::vector<JsonReader> JsonReader::array() const {
    if (value_->kind != JsonValue::Kind::array)
        fail("a list");
    std::vector<JsonReader> readers;
    for (std::size_t i = 0; i < value_->items.size(); ++i)
        readers.emplace_back(value_->items[i], *file_, name_ + "[" + std::to_string(i) + "]");
    return readers;
}

void JsonReader::accept_keys(std::initializer_list<std::string_view> keys) const {
    if (value_->kind != JsonValue::Kind::object)
        fail("an object with the keys " + joined(keys));
    for (const JsonMember& member : value_->members)
        if (std::find(keys.begin(), keys.end(), member.key) == keys.end())
            throw InputError(expected_found(*file_ + ":" + std::to_string(member.line), "one of " + joined(keys),
                                            "\"" + member.key.substr(0, 60) + "\""));
}

JsonReader JsonReader::operator[](std::string_view key) const {
    const JsonValue* member = find(key);
    if (!member)
        throw InputError(expected_found(
            where(), "the key \"" + std::string(key) + "\"" + (name_.empty() ? "" : " in " + name_), "none"));
    return {*member, *file_, (name_.empty() ? "" : name_ + ".") + std::string(key)};
}

const JsonValue* JsonReader::find(std::string_view key) const {
    for (const JsonMember& member : value_->members)
        if (member.key == key)
            return &member.value;
    return nullptr;
}

}  // namespace equistream
