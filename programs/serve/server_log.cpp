#include "server_log.h"

#include <equistream/json_text.h>

#include <nlohmann/json.hpp>

#include <cstdio>

namespace equistream::serve {

void log_event(cli::ProgressStyle style, const ViewerEvent& event) {
    if (style == cli::ProgressStyle::none)
        return;
    std::string line;
    if (style == cli::ProgressStyle::json) {
        line = json_text(nlohmann::json{{"event", event.what},
                                        {"viewer", event.viewer},
                                        {"address", event.address},
                                        {"bytes", event.bytes},
                                        {"detail", event.detail}});
    } else {
        line = "equistream serve: viewer " + (event.viewer > 0 ? std::to_string(event.viewer) + " " : "") + "from " +
               event.address + " " + event.what;
        if (!event.detail.empty())
            line += ": " + event.detail;
        if (event.bytes > 0)
            line += " (" + std::to_string(event.bytes) + " bytes sent)";
    }
    std::fputs((line + "\n").c_str(), stderr);
}

void log_note(cli::ProgressStyle style, const std::string& text) {
    if (style == cli::ProgressStyle::none)
        return;
    const std::string line = style == cli::ProgressStyle::json
                                 ? json_text(nlohmann::json{{"event", "note"}, {"detail", text}})
                                 : "equistream serve: " + text;
    std::fputs((line + "\n").c_str(), stderr);
}

}  // namespace equistream::serve
