/// Addresses, secrets, and connections that are encrypted by them.
#include <client/transport/address.h>
#include <client/transport/secret.h>
#include <client/transport/server_connection.h>
#include <client/transport/srt_line.h>
#include <client/transport/srt_wire.h>
#include <client/transport/wire.h>
#include <tests/unit/plugin/stream/synthetic.h>

#include <equistream/error.h>
#include <equistream/viewer_message.h>

#include <asio/executor_work_guard.hpp>
#include <asio/io_context.hpp>
#include <gtest/gtest.h>

#include <openssl/evp.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace equistream::test {
namespace {

const std::string secret = "a-secret-of-enough-letters";

TEST(ServerAddresses, AreReadAsTheyAreWritten) {
    const auto address = parse_server_address("tls://" + secret + "@[2001:db8::5]:9000").value();
    EXPECT_EQ(address.scheme, Scheme::tls);
    EXPECT_EQ(address.host, "2001:db8::5");
    EXPECT_EQ(address.port, 9000);
    EXPECT_EQ(address.secret, secret);
    EXPECT_EQ(address.text(), "tls://[2001:db8::5]:9000");
    EXPECT_EQ(address.text_with_secret(), "tls://" + secret + "@[2001:db8::5]:9000");
    EXPECT_EQ(parse_server_address("srt://host:1").value().scheme, Scheme::srt);
    EXPECT_EQ(parse_server_address("srt://host:1").value().parity, std::nullopt);
    EXPECT_EQ(parse_server_address("srt://a?b@host:1?parity=2").value().parity, 2);
    EXPECT_EQ(parse_server_address("srt://host:1?parity=100").value().text(), "srt://host:1?parity=100");
    EXPECT_EQ(parse_server_address("tcp://:0").value().text(), "tcp://:0");
    EXPECT_EQ(parse_server_address("tls://host:1").value().text_with_secret(), "tls://host:1");
    for (const char* bad :
         {"udp://:0", "tcp://127.0.0.1", "tcp://:65536", "tcp://:", "tcp://:-1", "tcp://::1:0", ":0", "tcp://[::1:9000",
          "tcp://secret@host:1", "tls://secret@:", "tls://a/b:1", "srt://host:1?parity=1", "srt://host:1?parity=101",
          "srt://host:1?parity=", "srt://host:1?", "tls://host:1?parity=2", ""})
        EXPECT_FALSE(parse_server_address(bad)) << bad;
}

TEST(ServerAddresses, KeepTheirSecretsToThemselves) {
    EXPECT_EQ(without_secrets("view tls://abc@host:1 --x 'tls://d@'e@host:2' a@b tls://host:3 tcp://h:4"),
              "view tls://***@host:1 --x 'tls://***@host:2' a@b tls://host:3 tcp://h:4");
    EXPECT_EQ(without_secrets("tls://"), "tls://");
}

TEST(Secrets, AreMadeOnceAndForTheirOwnerAlone) {
    const synthetic::Folder folder;
    const auto file = folder / "secret";
    const std::string made = read_or_make_secret(file);
    EXPECT_EQ(made.size(), 26u);
    EXPECT_NE(make_secret(), made);
    EXPECT_EQ(read_or_make_secret(file), made);
    EXPECT_EQ(std::filesystem::status(file).permissions(),
              std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
}

TEST(Secrets, ThatAreNoneAreRefused) {
    const synthetic::Folder folder;
    for (const std::string& bad :
         {std::string(), std::string(15, 'a'), std::string(129, 'a'), std::string(16, '@'), std::string(16, ' '),
          std::string(16, '\xe4'), std::string(16, '\''), std::string(16, '\\')}) {
        std::ofstream(folder / "bad") << bad << '\n';
        std::filesystem::permissions(folder / "bad",
                                     std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
        EXPECT_THROW(read_or_make_secret(folder / "bad"), InputError) << bad;
    }
    std::ofstream(folder / "open") << secret << '\n';
    std::filesystem::permissions(folder / "open", std::filesystem::perms::others_read,
                                 std::filesystem::perm_options::add);
    EXPECT_THROW(read_or_make_secret(folder / "open"), InputError);
    std::ofstream(folder / "empty");
    EXPECT_THROW(read_or_make_secret(folder / "empty"), InputError);
    EXPECT_THROW(read_or_make_secret(folder / "no/such/folder"), InputError);
}

/// Accepts one viewer, answers the first bytes that it says, and hears the rest.
class Answering {
public:
    enum class End { says_so, breaks_off };  // breaks_off: without a word, when it hears more

    /// Speaks by `context`, or plainly.
    Answering(std::shared_ptr<asio::ssl::context> context, std::string answer, End end = End::says_so,
              Scheme scheme = Scheme::tls, int parity = usual_parity)
        : context_(std::move(context)), answer_(std::move(answer)), end_(end) {
        if (scheme == Scheme::srt)
            listen_by_srt(parity);
        else
            listen_by_tcp();
        thread_ = std::thread([this] { io_.run(); });
    }
    ~Answering() {
        work_.reset();
        asio::post(io_, [this] {
            close_();
            if (wire_)
                wire_->close();
        });
        thread_.join();
    }
    /// Empty: no secret is said.
    std::string address(const std::string& its_secret) const {
        return scheme_ + (its_secret.empty() ? "" : its_secret + "@") + "127.0.0.1:" + std::to_string(port_);
    }
    std::future<std::string> heard() { return heard_.get_future(); }
    std::future<bool> agreed_with() { return agreed_.get_future(); }
    /// How hearing ended.
    std::future<asio::error_code> ended() { return ended_.get_future(); }

private:
    void listen_by_tcp() {
        using asio::ip::tcp;
        const auto acceptor = std::make_shared<tcp::acceptor>(io_, tcp::endpoint(asio::ip::address_v4::loopback(), 0));
        port_ = acceptor->local_endpoint().port();
        close_ = [acceptor] { acceptor->close(); };
        acceptor->async_accept([this](const asio::error_code& error, tcp::socket socket) {
            if (!error)
                open(context_ ? tls_wire(std::move(socket), context_, true) : tcp_wire(std::move(socket)));
        });
    }
    void listen_by_srt(int parity) {
        scheme_ = "srt://";
        const auto listener = std::make_shared<SrtListener>(
            io_.get_executor(), asio::ip::udp::endpoint(asio::ip::address_v4::loopback(), 0), context_, 10, parity);
        port_ = listener->address().port();
        close_ = [listener] { listener->close(); };
        listener->listen();
        listener->accept([this](const asio::error_code& error, std::unique_ptr<Wire> wire, const auto&) {
            if (!error)
                open(std::move(wire));
        });
    }
    void open(std::unique_ptr<Wire> wire) {
        wire_ = std::move(wire);
        wire_->open([this](const asio::error_code& refused) {
            agreed_.set_value(!refused);
            if (refused)
                return wire_->close();
            hear();
        });
    }
    void hear() {
        wire_->read_some(said_, [this](const asio::error_code& error, std::size_t count) {
            if (error)
                return ended_.set_value(error);
            if (!std::exchange(has_heard_, true)) {
                heard_.set_value(std::string(said_.data(), count));
                answer(0);
            } else if (end_ == End::breaks_off) {
                return wire_->close();
            }
            hear();
        });
    }
    void answer(std::size_t begin) {
        if (begin == answer_.size())
            return end_ == End::says_so ? wire_->end_writing() : void();
        wire_->write_some(std::span<const char>(answer_).subspan(begin),
                          [this, begin](const asio::error_code& error, std::size_t count) {
                              if (!error)
                                  answer(begin + count);
                          });
    }

    std::shared_ptr<asio::ssl::context> context_;
    std::string answer_;
    End end_;
    asio::io_context io_{1};
    std::optional<asio::executor_work_guard<asio::io_context::executor_type>> work_{io_.get_executor()};
    std::string scheme_ = "tls://";
    std::uint16_t port_ = 0;
    std::function<void()> close_;  // where it listens
    std::unique_ptr<Wire> wire_;
    bool has_heard_ = false;
    std::array<char, 256> said_{};
    std::promise<std::string> heard_;
    std::promise<bool> agreed_;
    std::promise<asio::error_code> ended_;
    std::thread thread_;
};

/// Why a client with this secret is not let in; empty: it is.
std::string refusal(const Answering& server, const std::string& its_secret) {
    try {
        const ServerConnection connection(server.address(its_secret), nullptr, {});
        return {};
    } catch (const InputError& error) {
        EXPECT_EQ(std::string(error.what()).find(its_secret), std::string::npos) << error.what();
        return error.what();
    }
}

std::string long_answer(std::size_t bytes) {
    std::string answer(bytes, ' ');
    for (std::size_t i = 0; i < answer.size(); ++i)
        answer[i] = char('a' + i % 23);
    return answer;
}

std::string all_of(ServerConnection& connection) {
    std::string got;
    std::array<std::uint8_t, 5000> block{};
    while (const std::size_t count = connection.read(block))
        got.append(block.begin(), block.begin() + std::ptrdiff_t(count));
    return got;
}

ViewerPose pose_at(double x_m) {
    return {1, {{x_m, 2, 3}, {1, 0, 0, 0}}, {}};
}

class EncryptedConnections : public testing::TestWithParam<Scheme> {};

INSTANTIATE_TEST_SUITE_P(Over, EncryptedConnections, testing::Values(Scheme::tls, Scheme::srt),
                         [](const auto& scheme) { return scheme.param == Scheme::tls ? "tls" : "srt"; });

TEST_P(EncryptedConnections, CarryBytesBothWaysAndTheirEnd) {
    const std::string answer = long_answer(1'000'000);
    Answering server(secret_context(secret, TlsRole::server), answer, Answering::End::says_so, GetParam());
    PoseSender poses;
    ServerConnection connection(server.address(secret), &poses, {});
    EXPECT_TRUE(poses.send(pose_at(1)));
    const std::string heard = server.heard().get();
    ViewerMessageReader reader;
    const auto pose = reader.take(std::vector<std::uint8_t>(heard.begin(), heard.end()));
    ASSERT_TRUE(pose);
    EXPECT_EQ(pose->head.position_m, glm::dvec3(1, 2, 3));
    const std::string got = all_of(connection);
    EXPECT_TRUE(got == answer) << got.size();
}

/// What a viewer says once the server has said all must take nothing of it back.
TEST_P(EncryptedConnections, HeadsThatMoveAfterTheEndLoseNothing) {
    const std::string answer = long_answer(12'000'000);
    Answering server(secret_context(secret, TlsRole::server), answer, Answering::End::says_so, GetParam());
    auto ended = server.ended();
    std::string got;
    {
        PoseSender poses;
        ServerConnection connection(server.address(secret), &poses, {});
        std::vector<std::uint8_t> block(200'000);
        double x_m = 0;
        for (std::size_t count = 1; count > 0;) {
            poses.send(pose_at(x_m += 1));
            std::this_thread::sleep_for(std::chrono::milliseconds(got.size() > 11'000'000 ? 40 : 1));
            count = connection.read(block);
            got.append(block.begin(), block.begin() + std::ptrdiff_t(count));
        }
    }
    EXPECT_TRUE(got == answer) << got.size();
    EXPECT_EQ(ended.get(), asio::error::eof);
}

TEST_P(EncryptedConnections, WhoeverReadsLateGetsAll) {
    const std::string answer = long_answer(12'000'000);
    Answering server(secret_context(secret, TlsRole::server), answer, Answering::End::says_so, GetParam());
    PoseSender poses;
    ServerConnection connection(server.address(secret), &poses, {});
    EXPECT_TRUE(poses.send(pose_at(1)));
    server.heard().get();
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    const std::string got = all_of(connection);
    EXPECT_TRUE(got == answer) << got.size();
}

TEST(SrtConnections, WhoeverReadsMuchTooLateIsCutOff) {
    Answering server(secret_context(secret, TlsRole::server), long_answer(40'000'000), Answering::End::says_so,
                     Scheme::srt);
    auto ended = server.ended();
    PoseSender poses;
    ServerConnection connection(server.address(secret), &poses, {});
    EXPECT_TRUE(poses.send(pose_at(1)));
    server.heard().get();
    ASSERT_EQ(ended.wait_for(std::chrono::seconds(60)), std::future_status::ready);
    std::vector<std::uint8_t> block(200'000);
    EXPECT_THROW(while (connection.read(block) > 0);, WorkError);
}

TEST_P(EncryptedConnections, OneThatIsCutIsNoEnd) {
    Answering server(secret_context(secret, TlsRole::server), "all", Answering::End::breaks_off, GetParam());
    PoseSender poses;
    ServerConnection connection(server.address(secret), &poses, {});
    poses.send(pose_at(1));
    std::array<std::uint8_t, 16> block{};
    EXPECT_EQ(connection.read(block), 3u);
    while (!poses.send(pose_at(2)))  // so many a second
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_THROW(connection.read(block), WorkError);
}

TEST(TlsConnections, TheEnvironmentMaySayTheSecret) {
    Answering server(secret_context(secret, TlsRole::server), "all");
    setenv(secret_variable, secret.c_str(), 1);
    EXPECT_NO_THROW(ServerConnection(server.address(""), nullptr, {}));
    unsetenv(secret_variable);
    EXPECT_THROW(ServerConnection(server.address(""), nullptr, {}), InputError);
}

TEST_P(EncryptedConnections, WhoeverKnowsAnotherSecretIsRefusedByBoth) {
    Answering server(secret_context(secret, TlsRole::server), "all", Answering::End::says_so, GetParam());
    auto agreed = server.agreed_with();
    EXPECT_NE(refusal(server, "another-secret-of-enough").find("expected a server with this secret"),
              std::string::npos);
    EXPECT_FALSE(agreed.get());
}

TEST(SrtConnections, BothEndsSendTheSameParity) {
    const std::string answer = long_answer(1'000'000);
    for (const int parity : {min_parity, max_parity}) {
        Answering server(secret_context(secret, TlsRole::server), answer, Answering::End::says_so, Scheme::srt, parity);
        PoseSender poses;
        ServerConnection connection(server.address(secret) + "?parity=" + std::to_string(parity), &poses, {});
        EXPECT_TRUE(poses.send(pose_at(1)));
        const std::string got = all_of(connection);
        EXPECT_TRUE(got == answer) << got.size();
    }
    const Answering other(secret_context(secret, TlsRole::server), answer, Answering::End::says_so, Scheme::srt, 2);
    EXPECT_NE(
        refusal(other, secret).find("expected a server with the same ?parity=N (here 10), found one with another"),
        std::string::npos);
}

/// Who is full closes before anything is agreed on.
TEST(TlsConnections, AServerThatHangsUpMayHaveNoRoom) {
    asio::io_context io;
    asio::ip::tcp::acceptor acceptor(io, asio::ip::tcp::endpoint(asio::ip::address_v4::loopback(), 0));
    std::thread closing([&] { acceptor.accept().close(); });
    const std::string address = "tls://" + secret + "@127.0.0.1:" + std::to_string(acceptor.local_endpoint().port());
    try {
        ServerConnection(address, nullptr, {});
        ADD_FAILURE() << "nobody is there";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("expected a server that has room for another viewer"),
                  std::string::npos)
            << error.what();
    }
    closing.join();
}

TEST(TlsConnections, APlainServerIsRefused) {
    Answering server(nullptr, "all");
    EXPECT_NE(refusal(server, secret), "");
}

TEST_P(EncryptedConnections, ACertificateDoesNotStandInForTheSecret) {
    const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> key(EVP_EC_gen("P-256"), EVP_PKEY_free);
    const std::unique_ptr<X509, decltype(&X509_free)> certificate(X509_new(), X509_free);
    X509_gmtime_adj(X509_getm_notBefore(certificate.get()), -3600);
    X509_gmtime_adj(X509_getm_notAfter(certificate.get()), 3600);
    X509_set_pubkey(certificate.get(), key.get());
    X509_NAME_add_entry_by_txt(X509_get_subject_name(certificate.get()), "CN", MBSTRING_ASC,
                               reinterpret_cast<const unsigned char*>("127.0.0.1"), -1, -1, 0);
    X509_set_issuer_name(certificate.get(), X509_get_subject_name(certificate.get()));
    ASSERT_GT(X509_sign(certificate.get(), key.get(), EVP_sha256()), 0);
    const auto context = std::make_shared<asio::ssl::context>(asio::ssl::context::tls_server);
    ASSERT_EQ(SSL_CTX_use_certificate(context->native_handle(), certificate.get()), 1);
    ASSERT_EQ(SSL_CTX_use_PrivateKey(context->native_handle(), key.get()), 1);
    Answering server(context, "all", Answering::End::says_so, GetParam());
    auto agreed = server.agreed_with();
    EXPECT_NE(refusal(server, secret).find("certificate"), std::string::npos);
    EXPECT_FALSE(agreed.get());
}

TEST(TcpSockets, AreImpatientAndSendAtOnce) {
    asio::io_context io;
    asio::ip::tcp::acceptor acceptor(io, {asio::ip::address_v4::loopback(), 0});
    asio::ip::tcp::socket socket(io);
    socket.connect(acceptor.local_endpoint());
    prepare(socket, 10);
    const auto option = [&](int level, int name) {
        int value = -1;
        socklen_t size = sizeof value;
        getsockopt(socket.native_handle(), level, name, &value, &size);
        return value;
    };
    EXPECT_GT(option(IPPROTO_TCP, TCP_NODELAY), 0);
    EXPECT_GT(option(SOL_SOCKET, SO_KEEPALIVE), 0);
    EXPECT_EQ(option(IPPROTO_TCP, TCP_KEEPIDLE), 2) << "a quarter of the patience";
    EXPECT_EQ(option(IPPROTO_TCP, TCP_KEEPINTVL), 2);
    EXPECT_EQ(option(IPPROTO_TCP, TCP_USER_TIMEOUT), 10'000);
    EXPECT_EQ(option(IPPROTO_TCP, TCP_NOTSENT_LOWAT), 1 << 14);
}

TEST(SrtSockets, WaitTwiceAsLongAsWhoeverUsesThem) {
    const auto started = SrtReactor::get();  // the library
    const auto idle_ms = [](double patience_s) {
        const SRTSOCKET socket = make_srt_socket(patience_s, 1, usual_parity);
        int value = -1, size = int(sizeof value);
        EXPECT_EQ(srt_getsockflag(socket, SRTO_PEERIDLETIMEO, &value, &size), 0);
        srt_close(socket);
        return value;
    };
    EXPECT_EQ(idle_ms(10), 20'000);
    EXPECT_EQ(idle_ms(0.5), 1'000);
    EXPECT_EQ(idle_ms(0.01), 100);
    EXPECT_EQ(idle_ms(1e9), 2'000'000);
}

TEST(TlsConnections, WhatIsSaidAfterTheEndIsReadSlowly) {
    Answering server(secret_context(secret, TlsRole::server), "all");
    asio::io_context io;
    asio::ip::tcp::socket socket(io);
    socket.connect({asio::ip::address_v4::loopback(), parse_server_address(server.address(secret))->port});
    const std::unique_ptr<Wire> wire = tls_wire(std::move(socket), secret_context(secret, TlsRole::client), false);
    const std::string much(1 << 16, 'x');
    std::size_t written = 0;
    std::function<void()> go_on = [&] {
        wire->write_some(much, [&](const asio::error_code& error, std::size_t count) {
            written += count;
            if (!error)
                go_on();
        });
    };
    wire->open([&](const asio::error_code& error) {
        if (!error)
            go_on();
    });
    for (int i = 0; i < 600 && written == 0; ++i)
        io.run_for(std::chrono::milliseconds(100));
    EXPECT_GT(written, 0u);
    io.run_for(std::chrono::seconds(2));
    EXPECT_LT(written, std::size_t{24} << 20) << "what systems on the way keep";
    wire->close();
    io.run_for(std::chrono::milliseconds(100));
}

}  // namespace
}  // namespace equistream::test
