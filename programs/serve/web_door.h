#pragma once
/// Viewers that come by a browser: hands out the page, and gives each WebSocket a connection to the server, with the
/// bytes that a viewer by TCP has. Its own thread; HTTP and WebSocket are Boost.Beast's, which web_door.cpp alone sees:
/// Boost.Asio and Asio do not stand each other.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>

namespace equistream::serve {

struct WebSettings {
    std::string address;     ///< that it listens on: "127.0.0.1", "::1"
    std::uint16_t port = 0;  ///< 0: one that is free
    double patience_s = 10;  ///< with one that does not say what it wants, or does not listen
    std::string page{};      ///< HTML
    /// Of https://, its private key among it (certificate.h); empty: http://.
    std::string certificate_pem{};
    /// What browsers must say to get the stream, as "/stream?key=SECRET"; empty: nothing.
    std::string secret{};
};

/// The page beside the programs, in share/equistream. Throws InputError where it is not there.
std::string read_web_page(const std::filesystem::path& program_folder);

/// Closes a file descriptor when it goes.
class Descriptor {
public:
    explicit Descriptor(int number) : number_(number) {}
    Descriptor(Descriptor&& other) noexcept : number_(other.release()) {}
    Descriptor& operator=(Descriptor&&) = delete;
    ~Descriptor();
    int number() const { return number_; }
    int release() { return std::exchange(number_, -1); }

private:
    int number_;
};

class WebDoor {
public:
    /// `server_end` is one end of a stream of bytes; the viewer is at this address and port.
    using Welcome = std::function<void(Descriptor server_end, const std::string& address, std::uint16_t port)>;

    /// Takes the address. `welcome` is called in a thread of the door's. Throws InputError where the address is taken,
    /// boost::system::system_error where OpenSSL does not take the certificate.
    WebDoor(WebSettings settings, Welcome welcome);
    /// Waits up to two seconds for what is still on its way to browsers, and closes all connections.
    ~WebDoor();

    /// Once: lets browsers in.
    void start();
    void stop_accepting();

    /// "http://127.0.0.1:8080/", with this machine's name where all its addresses are listened on. Without the secret.
    const std::string& url() const { return url_; }

private:
    struct Parts;

    std::unique_ptr<Parts> parts_;
    std::string url_;
};

}  // namespace equistream::serve
