#pragma once
/// A user's XML with our sensors and our integrator in the place of its own. Variant-independent: nodes, not objects.
#include "embedded_scene.h"

#include <mitsuba/core/parser.h>

#include <map>
#include <string>

namespace equistream::mitsuba_host {

/// Ids of our nodes, by which their objects are found again.
std::string our_sensor_id(std::size_t index);
inline constexpr const char* our_integrator_id = "equistream_integrator";

struct EditedXml {
    mitsuba::parser::ParserConfig config;
    mitsuba::parser::ParserState state;
    XmlSensor sensor;
    bool hides_emitters = false;                           ///< lamps are looked through
    std::map<std::string, std::string> group_of_instance;  ///< by their ids
};

/// Throws InputError with Mitsuba's words, file, line and column among them.
EditedXml read_and_edit(const SceneRequest& request, const std::string& variant);

// Mitsuba's messages, some of which are paragraphs, as one line.

/// Lines joined with single spaces, zero-width characters taken out.
std::string one_line(const std::string& message);

}  // namespace equistream::mitsuba_host
