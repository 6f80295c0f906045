#include "byte_server.h"

#include <programs/serve/server.h>

#include <asio/io_context.hpp>
#include <asio/post.hpp>

#include <algorithm>
#include <cstring>
#include <optional>
#include <span>
#include <thread>
#include <utility>

namespace equistream::bench {

namespace {

constexpr const char* this_machine = "127.0.0.1";

class Everything : public serve::Programme {
public:
    std::unique_ptr<serve::Feed> open_feed() override { return std::make_unique<Feed>(); }

private:
    class Feed : public serve::Feed {
    public:
        serve::Portion next(std::span<char> block, double elapsed_s) override {
            const std::size_t count = std::min(block.size(), sent_bytes - given_);
            std::memcpy(block.data(), what_is_sent().data() + given_, count);
            given_ += count;
            return {.bytes = count, .due_s = elapsed_s, .ended = count == 0};
        }

    private:
        std::size_t given_ = 0;
    };
};

}  // namespace

const std::vector<char>& what_is_sent() {
    static const std::vector<char> bytes(sent_bytes, 'x');
    return bytes;
}

struct ByteServer::Parts {
    asio::io_context io;
    Everything everything;
    std::optional<serve::Server> server;
    std::thread thread;
};

ByteServer::ByteServer(Scheme scheme, bool web) : parts_(std::make_unique<Parts>()) {
    const ServerAddress wanted{.scheme = scheme, .host = this_machine};
    auto door = serve::bind_door(parts_->io, wanted, secret, 10, "bench");
    door->listen("bench");
    ServerAddress address = door->address();
    if (is_encrypted(scheme))
        address.secret = secret;
    url_ = address.text_with_secret();
    serve::ServerSettings settings;
    settings.log = cli::ProgressStyle::none;
    if (web)
        settings.web = serve::WebSettings{.address = this_machine};
    parts_->server.emplace(parts_->io, std::move(door), parts_->everything, settings);
    parts_->server->start();
    parts_->thread = std::thread([parts = parts_.get()] { parts->io.run(); });
}

ByteServer::~ByteServer() {
    asio::post(parts_->io, [parts = parts_.get()] { parts->server->stop(); });
    parts_->thread.join();
}

std::uint16_t ByteServer::web_port() const {
    const std::string url = parts_->server->web_url();
    return std::uint16_t(std::stoi(url.substr(url.rfind(':') + 1)));
}

}  // namespace equistream::bench
