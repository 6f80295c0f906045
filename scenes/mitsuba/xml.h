#pragma once
/// The few kinds of XML elements that Mitsuba knows.
#include <glm/glm.hpp>
#include <pugixml.hpp>

#include <string>

namespace equistream::mitsuba_xml {

/// <TAG type="TYPE" id="ID" name="NAME">; id and name are left out where they are empty.
pugi::xml_node add_plugin(pugi::xml_node parent, const char* tag, const char* type, const std::string& id = {},
                          const char* name = "");

void add_text(pugi::xml_node parent, const char* name, const std::string& value);
void add_float(pugi::xml_node parent, const char* name, double value);
void add_integer(pugi::xml_node parent, const char* name, const std::string& value);
void add_boolean(pugi::xml_node parent, const char* name, bool value);
void add_rgb(pugi::xml_node parent, const char* name, const glm::dvec3& value);
void add_transform(pugi::xml_node parent, const char* name, const glm::dmat4& matrix);
void add_reference(pugi::xml_node parent, const std::string& id, const char* name = "");

}  // namespace equistream::mitsuba_xml
