#pragma once
/// JSON that remembers its lines. nlohmann::json's tree does not, so this small one is filled by its SAX parser,
/// which is fed through a cursor that counts what it has read. Errors are InputErrors that start with FILE:LINE.
#include <glm/glm.hpp>

#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace equistream {

struct JsonMember;

struct JsonValue {
    enum class Kind { null, boolean, number, text, array, object };

    Kind kind = Kind::null;
    int line = 0;
    bool boolean = false;
    double number = 0;
    std::string text;
    std::vector<JsonValue> items;
    std::vector<JsonMember> members;
};

struct JsonMember {
    std::string key;
    int line = 0;  ///< of the key
    JsonValue value;
};

/// Throws on anything that is not one JSON value, on repeated keys and on numbers outside double's range.
JsonValue parse_json(std::string_view text, const std::string& file);

/// A value together with what errors call it: reads typed values, or throws "FILE:LINE: expected ..., found ...".
class JsonReader {
public:
    /// `name` is how errors call the value ("camera.keys[2]"); the value must outlive the reader.
    JsonReader(const JsonValue& value, const std::string& file, std::string name)
        : value_(&value), file_(&file), name_(std::move(name)) {}

    /// "FILE:LINE"
    std::string where() const;
    [[noreturn]] void fail(const std::string& expected) const;

    double number() const;
    double number_above(double limit) const;
    double number_within(double least, double most) const;
    std::string text() const;
    glm::dvec3 vector3() const;
    /// [r, g, b] or one number for all three; none negative.
    glm::dvec3 colour() const;
    std::vector<double> numbers(std::size_t count) const;
    std::vector<JsonReader> array() const;

    /// Requires an object whose keys are all among these.
    void accept_keys(std::initializer_list<std::string_view> keys) const;
    bool has(std::string_view key) const { return find(key) != nullptr; }
    /// The member's reader; throws if there is none.
    JsonReader operator[](std::string_view key) const;

private:
    const JsonValue* find(std::string_view key) const;

    const JsonValue* value_;
    const std::string* file_;
    std::string name_;
};

}  // namespace equistream
