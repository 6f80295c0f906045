/// A viewer of a live server, by the client's C interface, whose head moves on steadily: where a picture's head was
/// says when its pose was sent.
///
///     equistream_live_viewer URL SECONDS
///
/// Prints JSON: of each picture when its pose was sent and when both eyes were there, on one clock, and how long
/// decoding it and rendering both eyes took.
#include <equistream/client.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace {

constexpr int width = 160, height = 90;  // small: the server works on the same machine
constexpr double fov_rad = 1.5708, ipd_m = 0.063;
constexpr double refresh_s = 1.0 / 30;
constexpr double metres_per_s = 0.001;  // slow enough to stay in the head box
constexpr double settled_s = 5;         // the server finds its pace, the client its delay

struct Failed : std::runtime_error {
    using runtime_error::runtime_error;
};

void check(es_status status, const es_error& error) {
    if (status != ES_OK)
        throw Failed(error.text);
}

nlohmann::ordered_json watch(const char* url, double seconds) {
    es_error error{};
    es_client_settings settings{};
    settings.struct_size = sizeof settings;
    settings.abi_version = ES_CLIENT_ABI_VERSION;
    settings.source = url;
    es_client* client = nullptr;
    check(es_client_open(&settings, &client, &error), error);
    es_client_source source{};
    source.struct_size = sizeof source;
    check(es_client_get_source(client, &source, &error), error);

    std::vector<std::uint8_t> pixels[2];
    es_eye_image images[2]{};
    for (int eye = 0; eye < 2; ++eye) {
        pixels[eye].resize(std::size_t{4} * width * height);
        images[eye].struct_size = sizeof images[eye];
        images[eye].pixels = pixels[eye].data();
    }
    es_client_request request{};
    request.struct_size = sizeof request;
    request.width = width;
    request.height = height;
    check(es_client_set_eyes(&request, fov_rad, ipd_m, &error), error);

    nlohmann::ordered_json shown = nlohmann::ordered_json::array();
    es_client_statistics statistics{};
    statistics.struct_size = sizeof statistics;
    double decoded_s = 0;  // of all pictures that were shown
    const double begun_s = es_client_now_s(client);
    for (double next_s = begun_s; next_s < begun_s + seconds; next_s += refresh_s) {
        std::this_thread::sleep_for(std::chrono::duration<double>(std::max(0.0, next_s - es_client_now_s(client))));
        const double now_s = es_client_now_s(client);
        request.head = source.first_head;
        request.head.position_m[0] += metres_per_s * now_s;
        check(es_client_send_head(client, &request.head, &error), error);
        request.display_s = now_s;
        es_client_state state{};
        state.struct_size = sizeof state;
        const double asked_s = es_client_now_s(client);
        check(es_client_render(client, &request, images, &state, &error), error);
        const double shown_s = es_client_now_s(client);
        if (state.is_over)
            break;
        if (!state.is_new)
            continue;
        check(es_client_get_statistics(client, &statistics, &error), error);
        const double before_s = std::exchange(decoded_s, 1e-3 * statistics.decode_ms * double(statistics.frames_shown));
        const double sent_s = (state.head.position_m[0] - source.first_head.position_m[0]) / metres_per_s;
        if (sent_s > settled_s)
            shown.push_back({{"sent_s", sent_s},
                             {"shown_s", shown_s},
                             {"decode_s", decoded_s - before_s},
                             {"render_s", shown_s - asked_s},
                             {"playout_delay_s", state.playout_delay_s}});
    }
    es_client_close(client);
    return nlohmann::ordered_json::object({{"shown", shown}});
}

}  // namespace

int main(int argc, char** argv) {
    try {
        const double seconds = argc == 3 ? std::strtod(argv[2], nullptr) : 0;
        if (!(seconds > settled_s))
            throw Failed("expected URL SECONDS, above " + std::to_string(settled_s));
        std::printf("%s\n", watch(argv[1], seconds).dump().c_str());
        return 0;
    } catch (const std::exception& problem) {
        std::fprintf(stderr, "equistream_live_viewer: %s\n", problem.what());
        return 1;
    }
}
