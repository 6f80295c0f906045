#pragma once
/// A scene rendered while it is watched: a renderer as a child, an encoder in a thread, a stream for all viewers.
#include "live_encoder.h"
#include "server.h"

#include <asio/signal_set.hpp>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace equistream::serve {

struct LiveSettings {
    std::string program;                 ///< of the host
    std::vector<std::string> arguments;  ///< of it, --follow among them
    std::uint32_t max_spp = 16;
    double spheres_per_s = 2;  ///< to be kept up with fewer samples, where need be
    LiveCoding coding;
    ServerSettings server;
};

/// Times are means, of spheres that followed one another without a pause.
struct LiveFigures {
    std::int64_t spheres = 0;
    double spheres_per_s = 0;
    std::uint32_t spp = 0;  ///< at the end
    double render_s = 0, write_s = 0, encode_s = 0;
    double age_s = 0;  ///< from when a sphere's place was taken to when its bytes could be sent
    std::int64_t poses = 0;
    ServerFigures server;
};

/// Until a signal of `stop` comes; whoever watches gets what there is and the stream's end. Calls `listening` once
/// viewers may come. Throws what ended the renderer, where it was not asked to end, in the same order.
LiveFigures serve_live(asio::io_context& io, asio::signal_set& stop, asio::ip::tcp::acceptor acceptor,
                       const LiveSettings& settings, const std::function<void()>& listening);

}  // namespace equistream::serve
