#include "provenance.h"

#include <client/transport/address.h>
#include <equistream/threads.h>

#include <fstream>

namespace equistream::cli {

namespace {

std::string cpu_model() {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("model name") && line.find(": ") != std::string::npos)
            return line.substr(line.find(": ") + 2);
    return "unknown";
}

}  // namespace

nlohmann::ordered_json provenance(const std::string& command) {
    return {{"command", without_secrets(command)},
            {"version", EQUISTREAM_VERSION},
            {"machine", {{"cpu", cpu_model()}, {"threads", usable_processors()}}}};
}

}  // namespace equistream::cli
