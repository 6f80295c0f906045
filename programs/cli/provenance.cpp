#include "provenance.h"

#include <client/transport/address.h>

#include <fstream>
#include <thread>

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
            {"machine", {{"cpu", cpu_model()}, {"threads", std::thread::hardware_concurrency()}}}};
}

}  // namespace equistream::cli
