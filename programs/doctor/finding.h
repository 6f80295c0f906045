#pragma once
/// What was found of one thing that programs need; probes hand it to `doctor` as JSON.
#include <nlohmann/json.hpp>

#include <string>
#include <utility>

namespace equistream::doctor {

enum class State {
    ok,
    missing,
    broken,  ///< there, but it crashed, hung or failed
};
// The first stands for whatever is not known.
NLOHMANN_JSON_SERIALIZE_ENUM(State, {{State::broken, "broken"}, {State::ok, "ok"}, {State::missing, "missing"}})

struct Finding {
    State state = State::missing;
    std::string found;               ///< in one line
    std::string get;                 ///< how to get what is missing; empty: as the table of checks says
    nlohmann::ordered_json details;  ///< more, for --json

    static Finding ok(std::string found, nlohmann::ordered_json details = {}) {
        return {State::ok, std::move(found), "", std::move(details)};
    }
};

inline nlohmann::ordered_json json_of(const Finding& finding) {
    return {{"state", finding.state}, {"found", finding.found}, {"get", finding.get}, {"details", finding.details}};
}

/// Throws nlohmann::json::exception where it is none.
inline Finding finding_of(const nlohmann::ordered_json& json) {
    return {json.at("state"), json.at("found"), json.at("get"), json.at("details")};
}

}  // namespace equistream::doctor
