/// equistream serve: a recorded stream to viewers over the network.
#include "encode_child.h"
#include "listen_address.h"
#include "server.h"

#include <equistream/error.h>
#include <equistream/formatted.h>
#include <equistream_cli/program.h>
#include <equistream_cli/scratch_folder.h>

#include <asio/io_context.hpp>
#include <nlohmann/json.hpp>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>

namespace equistream::serve {

namespace {

constexpr double most_patience_s = 86400;

struct Options {
    std::string source, listen;
    std::vector<std::string> encode;
    ServerSettings server;
    std::string progress = "auto";
    bool json = false;
};

void check(const Options& options) {
    if (!(options.server.viewer.patience_s >= 0.1 && options.server.viewer.patience_s <= most_patience_s))
        throw InputError(expected_found("--patience", "0.1 to 86400 s", in_words(options.server.viewer.patience_s)));
    if (options.server.most_viewers < 1)
        throw InputError(expected_found("--viewers", "at least 1", std::to_string(options.server.most_viewers)));
    if (!std::filesystem::exists(options.source))
        throw InputError(options.source + ": no such file or folder");
    if (!options.encode.empty() && !std::filesystem::is_directory(options.source))
        throw InputError(expected_found(options.source, "a folder, to encode with what follows --", "a file"));
}

void check_loop(const Recording& recording, const Options& options) {
    if (options.server.viewer.loop && !recording.is_matroska())
        throw InputError(expected_found(
            options.source, "Matroska for --loop, which can be read end to end again and again", "another container"));
}

/// For scripts that wait for it.
void say_listening(const std::string& url, bool json) {
    std::printf("%s\n", json ? nlohmann::json{{"listening", url}}.dump().c_str() : ("listening on " + url).c_str());
    if (std::fflush(stdout) != 0)
        throw WorkError("standard output: could not be written");
}

void report(const ServerFigures& figures, bool json) {
    if (json)
        std::printf("%s\n", nlohmann::json{{"viewers", figures.viewers},
                                           {"refused", figures.refused},
                                           {"dropped", figures.dropped},
                                           {"bytes_sent", figures.bytes_sent}}
                                .dump()
                                .c_str());
    else
        std::printf("viewers served %d, refused %d, dropped %d; %lld bytes sent\n", figures.viewers, figures.refused,
                    figures.dropped, static_cast<long long>(figures.bytes_sent));
}

void run(const Options& options) {
    check(options);
    asio::io_context io{1};
    asio::ip::tcp::acceptor acceptor = bind_to(io, parse_listen_address(options.listen, "--listen"), "--listen");
    asio::signal_set stop(io, SIGINT, SIGTERM);
    std::string file = options.source;
    std::optional<cli::ScratchFolder> scratch;
    if (std::filesystem::is_directory(options.source)) {
        scratch.emplace("serve");
        file = scratch->file("stream.mkv");
        setenv("TMPDIR", scratch->path().c_str(), 1);  // the child's trials go with the rest, however it ends
        std::vector<std::string> arguments{options.source, "--out", file, "--progress", options.progress};
        arguments.insert(arguments.end(), options.encode.begin(), options.encode.end());
        if (!run_encode(io, stop, arguments))
            return;
    }
    std::signal(SIGPIPE, SIG_IGN);  // whoever reads the log may leave
    const Recording recording(file);
    check_loop(recording, options);
    asio::error_code error;
    acceptor.listen(asio::socket_base::max_listen_connections, error);
    if (error)
        throw InputError(expected_found("--listen " + options.listen, "an address that is free", error.message()));
    const std::string url = url_of(acceptor.local_endpoint());
    Server server(std::move(acceptor), recording, options.server);
    stop.async_wait([&](const asio::error_code& cancelled, int) {
        if (!cancelled)
            server.stop();
    });
    server.start();
    say_listening(url, options.json);
    io.run();
    report(server.figures(), options.json);
}

std::function<void()> set_up(CLI::App& app, Options& options) {
    app.add_option(
           "SOURCE", options.source,
           "A recorded stream (.mkv or .mp4 as encode writes them), or a render's folder, which is encoded first")
        ->required();
    app.add_option("ENCODE_OPTIONS", options.encode,
                   "After --: what equistream encode is told about the folder, --depth auto for example");
    app.add_option("--listen", options.listen,
                   "tcp://HOST:PORT; without a host this machine alone can connect (127.0.0.1), port 0 is one that is "
                   "free")
        ->required();
    app.add_option("--viewers", options.server.most_viewers, "At a time; more are refused")->capture_default_str();
    app.add_option("--patience", options.server.viewer.patience_s,
                   "Seconds after which a viewer that does not read is dropped")
        ->capture_default_str();
    app.add_flag("--loop", options.server.viewer.loop, "Each viewer gets the stream over and over (.mkv only)");
    app.add_flag("--json", options.json, "The address, and a report at the end, as a line of JSON each");
    app.add_option("--progress", options.progress,
                   "auto: viewers' coming and going in words; json: as lines of JSON; none")
        ->capture_default_str();
    return [&options] {
        options.server.log = cli::parse_progress(options.progress);
        run(options);
    };
}

}  // namespace

}  // namespace equistream::serve

int main(int argc, char** argv) {
    equistream::serve::Options options;
    return equistream::cli::run_program(
        argc, argv,
        {"serve", "Send a recorded stream to viewers over the network, in time",
         "equistream serve sponza.mkv --listen tcp://:9000    # and: equistream view tcp://127.0.0.1:9000"},
        [&](CLI::App& app) { return equistream::serve::set_up(app, options); });
}
