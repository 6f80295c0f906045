/// equistream serve: a recorded stream, or a scene as it is rendered, to viewers over the network.
#include "certificate.h"
#include "children.h"
#include "live.h"
#include "programmes.h"
#include "server.h"

#include <client/transport/secret.h>
#include <equistream/error.h>
#include <equistream/json_text.h>
#include <equistream/text.h>
#include <programs/cli/process.h>
#include <programs/cli/program.h>
#include <programs/cli/provenance.h>

#include <asio/io_context.hpp>
#include <nlohmann/json.hpp>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

namespace equistream::serve {

namespace {

constexpr double max_patience_s = 86400;
/// A file of so many bytes takes some disks seconds to read, in which nobody can come.
constexpr std::uintmax_t large_file_bytes = std::uintmax_t{1} << 30;

struct Options {
    std::string command, source, listen, web, secret_file, certificate;
    std::string fingerprint;        ///< of the certificate by which browsers come; empty: they come by http://
    std::vector<std::string> more;  ///< behind --
    LiveOptions live;
    std::string progress = "auto";
    bool open = false, loop = false, json = false;
};

void check(const Options& options) {
    const ServerSettings& server = options.live.settings.server;
    cli::require(server.patience_s >= 0.1 && server.patience_s <= max_patience_s, "--patience", "0.1 to 86400 s",
                 in_words(server.patience_s));
    cli::require(!options.listen.empty() || !options.web.empty(), "--listen", "tcp://HOST:PORT, or --web PORT",
                 "neither");
    cli::require(options.certificate.empty() || !options.web.empty(), "--certificate",
                 "--web https://HOST:PORT as well", "none");
    cli::require(server.max_viewers >= 1, "--viewers", "at least 1", std::to_string(server.max_viewers));
    cli::require(server.per_address.value_or(1) >= 1, "--per-address", "at least 1",
                 std::to_string(server.per_address.value_or(1)));
    if (!std::filesystem::exists(options.source))
        throw InputError(options.source + ": no such file or folder");
    cli::require(std::filesystem::is_regular_file(options.source) || std::filesystem::is_directory(options.source),
                 options.source, "a file or a folder", "something else");
    cli::require(options.more.empty() || is_scene(options.source) || std::filesystem::is_directory(options.source),
                 options.source, "a folder or a scene, for the options after --", "a file");
}

/// For scripts that wait for it. `web`: where browsers go, or empty.
void say_listening(const Options& options, const std::string& url, const std::string& web) {
    nlohmann::ordered_json line{{"listening", url}};
    if (!web.empty())
        line["web"] = web;
    if (!options.fingerprint.empty())
        line["certificate"] = options.fingerprint;
    std::string text = "listening on " + url + (web.empty() ? "" : ", for browsers on " + web);
    if (!options.fingerprint.empty())
        text += "\ncertificate's SHA-256, which browsers show: " + options.fingerprint;
    std::printf("%s\n", options.json ? json_text(line).c_str() : text.c_str());
    if (std::fflush(stdout) != 0)
        throw WorkError("standard output: could not be written");
}

nlohmann::ordered_json as_json(const Options& options, const ServerFigures& figures) {
    nlohmann::ordered_json json = cli::provenance(options.command);
    json.update(nlohmann::ordered_json{{"viewers", figures.viewers},
                                       {"refused", figures.refused},
                                       {"dropped", figures.dropped},
                                       {"bytes_sent", figures.bytes_sent}});
    return json;
}

void report(const Options& options, const ServerFigures& figures) {
    if (options.json)
        std::printf("%s\n", json_text(as_json(options, figures)).c_str());
    else
        std::printf("viewers served %d, refused %d, dropped %d; %lld bytes sent\n", figures.viewers, figures.refused,
                    figures.dropped, static_cast<long long>(figures.bytes_sent));
}

void report(const Options& options, const LiveFigures& figures) {
    if (options.json) {
        nlohmann::ordered_json line = as_json(options, figures.server);
        line["live"] = {{"spheres", figures.spheres},
                        {"spheres_per_s", figures.spheres_per_s},
                        {"spp", figures.samples.looked_at},
                        {"render_s", figures.render_s},
                        {"write_s", figures.write_s},
                        {"encode_s", figures.encode_s},
                        {"crf", figures.crf},
                        {"mbit_per_s", figures.coded_mbps},
                        {"missed", figures.missed},
                        {"age_s", figures.age_s},
                        {"stages_ms", figures.stages.json()},
                        {"poses", figures.poses}};
        if (figures.samples.base) {
            line["live"]["base_spp"] = *figures.samples.base;
            line["live"]["window_pixels"] = figures.window_pixels;
        }
        std::printf("%s\n", json_text(line).c_str());
        return;
    }
    report(options, figures.server);
    const std::string fewer =
        figures.window_pixels < 1 ? formatted(" and %.2g of the window's pixels", figures.window_pixels) : "";
    std::printf("%lld spheres, %.2f a second, at last with %s, CRF %.1f%s; %.2f Mbit/s; %lld poses received\n"
                "ms a sphere: render %.0f, write %.0f, encode %.0f; %.0f from its order to bytes that can be sent\n",
                static_cast<long long>(figures.spheres), figures.spheres_per_s, samples_text(figures.samples).c_str(),
                figures.crf, fewer.c_str(), figures.coded_mbps, static_cast<long long>(figures.poses),
                1e3 * figures.render_s, 1e3 * figures.write_s, 1e3 * figures.encode_s, 1e3 * figures.age_s);
}

ServerAddress listen_address(const std::string& listen) {
    auto address = parse_server_address(listen);
    cli::require(
        address.has_value(), "--listen",
        "tcp://HOST:PORT, tls://HOST:PORT or srt://HOST:PORT, with a port of 0 to 65535 (after it, with srt://, "
        "?parity=2 to 100 if wanted)",
        "'" + without_secrets(listen) + "'");
    return *address;
}

/// The address's, the file's or the environment's; one that was made here where there is none.
std::string secret_for(const ServerAddress& address, const std::string& file) {
    const char* const variable = std::getenv(secret_variable);
    cli::require(address.secret.empty() || file.empty(), "--secret-file", "an address without a secret",
                 "--listen with one");
    if (!address.secret.empty()) {
        require_secret(address.secret, "--listen " + address.text());
        return address.secret;
    }
    if (!file.empty())
        return read_or_make_secret(file);
    if (variable == nullptr)
        return make_secret();
    require_secret(variable, secret_variable);
    return variable;
}

const char* const needs_open =
    "tls:// or srt:// beyond this machine, or --open, which lets everybody watch and move the camera";

/// Said with --progress none too: it is a warning.
void say_who_can_come(cli::ProgressStyle log, const std::string& url, bool is_encrypted) {
    if (log == cli::ProgressStyle::none)
        log = cli::ProgressStyle::automatic;
    log_note(log, is_encrypted ? "anyone with the secret who can reach " + url +
                                     " can watch, and move the camera of a scene (docs/security.md)"
                               : "anyone who can reach " + url +
                                     " can watch, and move the camera of a scene: no secret, no encryption (--open, "
                                     "docs/security.md)");
}

constexpr std::string_view https = "https://";

bool has_https(const Options& options) {
    return options.web.starts_with(https);
}

/// Of --web: PORT on this machine alone, HOST:PORT, or https://HOST:PORT, whose fingerprint is noted.
WebSettings web_settings(Options& options) {
    const bool has_tls = has_https(options);
    const std::string place = has_tls ? options.web.substr(https.size()) : options.web;
    const bool has_host = place.find(':') != std::string::npos;
    const auto address = parse_server_address((has_host ? "tcp://" : "tcp://:") + place);
    cli::require(address.has_value(), "--web", "PORT, HOST:PORT or https://HOST:PORT",
                 "'" + without_secrets(options.web) + "'");
    cli::require(has_tls || options.certificate.empty(), "--certificate", "--web https://HOST:PORT as well",
                 options.web);
    const asio::ip::tcp::endpoint endpoint = resolve(*address, "--web");
    WebSettings settings{.address = endpoint.address().to_string(),
                         .port = endpoint.port(),
                         .patience_s = options.live.settings.server.patience_s,
                         .page = read_web_page(cli::own_folder())};
    if (has_tls) {
        const Certificate certificate =
            options.certificate.empty() ? make_certificate() : read_or_make_certificate(options.certificate);
        settings.certificate_pem = certificate.pem;
        options.fingerprint = certificate.fingerprint;
    } else if (!endpoint.address().is_loopback()) {
        cli::require(options.open, "--web " + options.web, "https:// before it, or --open, which lets everybody watch",
                     "neither");
        say_who_can_come(options.live.settings.server.log, "the page of --web " + options.web, false);
    }
    return settings;
}

/// Where viewers may come, and what ends it.
struct Entrance {
    asio::io_context io{1};
    ServerAddress wanted;
    bool needs_secret;   ///< of viewers or of browsers
    std::string secret;  ///< empty: none is needed
    std::unique_ptr<Door> door;
    asio::signal_set stop;
    ServerAddress address;  ///< as it listens; with the secret where nobody else knows it
    bool is_new = false;    ///< the secret was made here

    /// Browsers need no --listen; there is a port for other viewers all the same.
    explicit Entrance(const Options& options)
        : wanted(listen_address(options.listen.empty() ? "tcp://:0" : options.listen)),
          needs_secret(is_encrypted(wanted.scheme) || has_https(options)),
          secret(needs_secret ? secret_for(wanted, options.secret_file) : ""),
          door(bind_door(io, wanted, secret, options.live.settings.server.patience_s, "--listen")),
          stop(io, SIGINT, SIGTERM), address(door->address()) {
        const bool is_safe = is_encrypted(wanted.scheme);
        cli::require(needs_secret || options.secret_file.empty(), "--secret-file",
                     "--listen tls:// or srt://, or --web https://, as well", wanted.text());
        cli::require(is_safe || options.open || door->is_local(), "--listen " + wanted.text(), needs_open, "neither");
        is_new = wanted.secret.empty() && options.secret_file.empty() && std::getenv(secret_variable) == nullptr;
        if (is_safe && is_new)
            address.secret = secret;
    }

    ServerSettings with_secret(ServerSettings settings) const {
        if (settings.web && !settings.web->certificate_pem.empty())
            settings.web->secret = secret;
        return settings;
    }

    /// Where browsers go; with the secret where nobody else knows it.
    std::string web_text(const Options& options, const std::string& url) const {
        return has_https(options) && is_new ? url + "#" + secret : url;
    }

    /// Says who can come.
    void open(cli::ProgressStyle log) const {
        door->listen("--listen");
        if (!door->is_local())
            say_who_can_come(log, address.text(), is_encrypted(wanted.scheme));
    }
};

/// What the child leaves there goes with the rest, however it ends.
cli::ScratchFolder& make_scratch(std::optional<cli::ScratchFolder>& scratch) {
    scratch.emplace("serve");
    setenv("TMPDIR", scratch->path().c_str(), 1);
    return *scratch;
}

/// Null where `stopped`, which is asked meanwhile, says so.
std::unique_ptr<Programme> read_recording(const Options& options, const std::string& file,
                                          const std::function<bool()>& stopped) {
    std::error_code error;
    if (const std::uintmax_t bytes = std::filesystem::file_size(file, error); !error && bytes >= large_file_bytes)
        log_note(options.live.settings.server.log,
                 "reading " + file + formatted(" (%.1f GB), to find the times of its frames", double(bytes) / 1e9));
    try {
        std::unique_ptr<Programme> recording = open_recording(file, options.loop, stopped);
        return stopped() ? nullptr : std::move(recording);
    } catch (const std::exception&) {  // what was read until then may be too little
        if (stopped())
            return nullptr;
        throw;
    }
}

void run_recorded(const Options& options) {
    Entrance entrance(options);
    std::string file = options.source;
    std::optional<cli::ScratchFolder> scratch;
    if (std::filesystem::is_directory(options.source)) {
        file = make_scratch(scratch).file("stream.mkv");
        std::vector<std::string> arguments{options.source, "--out", file, "--progress", options.progress};
        arguments.insert(arguments.end(), options.more.begin(), options.more.end());
        if (!run_encode(entrance.io, entrance.stop, arguments))
            return report(options, ServerFigures{});
    }
    std::signal(SIGPIPE, SIG_IGN);  // whoever reads the log may leave
    bool stopped = false;
    Server* running = nullptr;
    entrance.stop.async_wait([&](const asio::error_code& cancelled, int) {
        stopped = !cancelled;
        if (stopped && running != nullptr)
            running->stop();
    });
    const std::unique_ptr<Programme> recording = read_recording(options, file, [&] {
        entrance.io.poll();
        return stopped;
    });
    if (!recording)
        return report(options, ServerFigures{});
    entrance.open(options.live.settings.server.log);
    Server server(entrance.io, std::move(entrance.door), *recording,
                  entrance.with_secret(options.live.settings.server));
    running = &server;
    server.start();
    say_listening(options, entrance.address.text_with_secret(), entrance.web_text(options, server.web_url()));
    entrance.io.run();
    report(options, server.figures());
}

void run_live(const Options& options) {
    cli::require(!options.loop, "--loop: " + options.source, "a recorded stream", "a scene");
    Entrance entrance(options);
    std::signal(SIGPIPE, SIG_IGN);
    std::optional<cli::ScratchFolder> scratch;
    LiveSettings settings = live_settings(options.live, options.source, make_scratch(scratch).path(), options.more);
    settings.server = entrance.with_secret(settings.server);
    entrance.open(options.live.settings.server.log);
    const LiveFigures figures =
        serve_live(entrance.io, entrance.stop, std::move(entrance.door), settings, [&](const std::string& web) {
            say_listening(options, entrance.address.text_with_secret(), entrance.web_text(options, web));
        });
    if (!settings.coding.out.empty() && figures.spheres == 0)
        log_note(settings.server.log, "no sphere was rendered, so " + settings.coding.out + " was not written");
    report(options, figures);
}

std::function<void()> set_up(cli::CommandLine& app, Options& options) {
    ServerSettings& server = options.live.settings.server;
    app.add_option("SOURCE", options.source,
                   "A recorded stream (.mkv or .mp4 as encode writes them), a render's folder, which is encoded first, "
                   "or a scene (.json, or .xml of Mitsuba), which is rendered while it is watched")
        .required();
    app.add_option("MORE", options.more,
                   "After --: options of equistream encode for a folder, such as --depth auto, or of equistream render "
                   "for a scene");
    app.add_option(
        "--listen", options.listen,
        "tcp://HOST:PORT; tls://HOST:PORT, encrypted, for viewers with the secret; srt://HOST:PORT, the "
        "same over UDP, for networks that lose packets; ?parity=N after it sends 2 packets of parity for each N others "
        "(N from 2 to 100; usually 10). Without a host only this machine can connect (127.0.0.1). Port 0: any free "
        "port. Required without --web");
    app.add_option("--web", options.web,
                   "PORT or HOST:PORT of a page that shows the stream in a browser. https://HOST:PORT: encrypted, for "
                   "viewers with the secret. Without a host only this machine can open it");
    app.add_option("--certificate", options.certificate,
                   "PEM file with the private key and certificate of https://. If the file is missing, a self-signed "
                   "certificate is written to it. Without this option each start makes a new one");
    app.add_option("--secret-file", options.secret_file,
                   "File whose first line is the secret of tls://, srt:// and https://. If the file is missing, it is "
                   "made. Without this option the variable EQUISTREAM_SECRET is used, or a new secret, which is "
                   "printed with the address");
    app.add_flag("--open", options.open,
                 "Allow tcp:// or --web HOST:PORT beyond this machine. Anybody who can connect may watch, and move the "
                 "camera of a live scene");
    cli::add_with_default(app, "--viewers", server.max_viewers, "Viewers at a time; more are refused");
    app.add_option("--per-address", server.per_address,
                   "Viewers at a time from one address (default: 4, and any number from this machine)");
    cli::add_with_default(app, "--patience", server.patience_s,
                          "Seconds. A viewer that reads nothing for this long, or stays this far behind, is dropped");
    app.add_flag("--loop", options.loop, "Each viewer gets the stream over and over (.mkv without tiles only)");
    cli::add_json_flag(app, options.json)
        .description("Report as JSON on standard output: a line with the address, and one at the end");
    cli::add_progress_option(app, options.progress)
        .description("Viewers that come and go, on standard error. auto: in words; json: a line of JSON each; none: "
                     "nothing but who can connect");
    add_live_options(app, options.live);
    return [&options, &app] {
        LiveSettings& live = options.live.settings;
        live.server.log = cli::parse_progress(options.progress);
        check(options);
        if (!options.web.empty()) {
            live.server.web = web_settings(options);
            live.coding.longest_group_s = 2;
            live.coding.depth_code = DepthCodeId::pece420;  // browsers decode it on every device
        }
        if (is_scene(options.source))
            return run_live(options);
        require_live_options_unused(app, options.source);
        run_recorded(options);
    };
}

}  // namespace

}  // namespace equistream::serve

int main(int argc, char** argv) {
    equistream::serve::Options options;
    options.command = equistream::cli::quoted_command(argc, argv);
    return equistream::cli::run_program(
        argc, argv,
        {"serve", "Send a recorded stream to viewers over the network, in time, or a scene as it is rendered",
         "equistream serve pavilion.json --listen tcp://:9000    # and: equistream view tcp://127.0.0.1:9000 --scene "
         "pavilion.json"},
        [&](equistream::cli::CommandLine& app) { return equistream::serve::set_up(app, options); });
}
