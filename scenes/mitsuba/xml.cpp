#include "xml.h"

#include <charconv>

namespace equistream::mitsuba_xml {
namespace {

/// Shortest text that reads back as the same float: Mitsuba's numbers are floats, and a locale may not change them.
std::string number_text(double value) {
    char text[32];
    const auto [end, error] = std::to_chars(text, text + sizeof text, static_cast<float>(value));
    return error == std::errc() ? std::string(text, end) : std::string("0");
}

void add_value(pugi::xml_node parent, const char* tag, const char* name, const std::string& value) {
    pugi::xml_node node = parent.append_child(tag);
    node.append_attribute("name") = name;
    node.append_attribute("value") = value.c_str();
}

}  // namespace

pugi::xml_node add_plugin(pugi::xml_node parent, const char* tag, const char* type, const std::string& id,
                          const char* name) {
    pugi::xml_node node = parent.append_child(tag);
    node.append_attribute("type") = type;
    if (!id.empty())
        node.append_attribute("id") = id.c_str();
    if (*name)
        node.append_attribute("name") = name;
    return node;
}

void add_text(pugi::xml_node parent, const char* name, const std::string& value) {
    add_value(parent, "string", name, value);
}

void add_float(pugi::xml_node parent, const char* name, double value) {
    add_value(parent, "float", name, number_text(value));
}

void add_integer(pugi::xml_node parent, const char* name, const std::string& value) {
    add_value(parent, "integer", name, value);
}

void add_boolean(pugi::xml_node parent, const char* name, bool value) {
    add_value(parent, "boolean", name, value ? "true" : "false");
}

void add_rgb(pugi::xml_node parent, const char* name, const glm::dvec3& value) {
    add_value(parent, "rgb", name, number_text(value.x) + " " + number_text(value.y) + " " + number_text(value.z));
}

void add_transform(pugi::xml_node parent, const char* name, const glm::dmat4& matrix) {
    std::string rows;
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
            rows += (rows.empty() ? "" : " ") + number_text(matrix[column][row]);
    pugi::xml_node node = parent.append_child("transform");
    node.append_attribute("name") = name;
    node.append_child("matrix").append_attribute("value") = rows.c_str();
}

void add_reference(pugi::xml_node parent, const std::string& id, const char* name) {
    pugi::xml_node node = parent.append_child("ref");
    node.append_attribute("id") = id.c_str();
    if (*name)
        node.append_attribute("name") = name;
}

}  // namespace equistream::mitsuba_xml
