/// equistream info: explains any file of ours.
#include "describe.h"

#include <equistream/error.h>
#include <equistream/file_kind.h>
#include <equistream/json_text.h>
#include <equistream/stream.h>
#include <programs/cli/program.h>
#include <programs/cli/provenance.h>

#include <cstdio>

namespace equistream {

namespace {

struct Options {
    std::string command, source;
    bool json = false;
    bool frames = false;
    std::string progress = "auto";
    std::filesystem::path pictures;
};

/// A named pipe may have no writer, and a device no end.
void require_readable(const std::string& source) {
    if (is_url(source))
        return;
    const std::string expected = "a file, a folder or a URL";
    const std::filesystem::file_type type = type_of(source, expected);
    if (type == std::filesystem::file_type::not_found)
        throw InputError(source + ": no such file or folder");
    if (type != std::filesystem::file_type::regular && type != std::filesystem::file_type::directory)
        throw InputError(
            expected_found(source, expected, "a named pipe or a device (info pipe:0 reads standard input)"));
}

Description describe(const Options& options, cli::ProgressStyle progress) {
    const bool url = is_url(options.source);
    const DescribeOptions wanted{options.frames, options.json, progress};
    std::error_code error;
    if (!url && std::filesystem::is_directory(options.source, error))
        return describe_folder(options.source, wanted);
    if (!url && is_exr(options.source))
        return describe_exr(options.source);
    return describe_stream(options.source, wanted);
}

std::string report(const Options& options, const Description& description) {
    if (!options.json)
        return description.text;
    nlohmann::ordered_json json = cli::provenance(options.command);
    json.update(nlohmann::ordered_json(description.json));
    return json_text(json, 2) + "\n";
}

std::function<void()> set_up(cli::CommandLine& app, Options& options) {
    app.add_option("SOURCE", options.source, "A stream (file or URL), an EXR frame, or a folder of frames").required();
    cli::add_json_flag(app, options.json);
    app.add_flag("--frames", options.frames, "List every frame with its pose");
    app.add_option("--pictures", options.pictures,
                   "Also write a PNG of every plane (depth, motion, ids, ... in false colours) into this folder");
    cli::add_progress_option(app, options.progress);
    return [&options] {
        const cli::ProgressStyle progress = cli::parse_progress(options.progress);
        cli::hide_secret(options.source);
        require_readable(options.source);
        std::size_t pictures = 0;
        if (!options.pictures.empty())
            pictures = write_pictures(options.source, options.pictures, progress);
        Description description = describe(options, progress);
        if (!options.pictures.empty()) {
            description.text += shown(options.pictures.string()) + formatted(": %zu pictures written\n", pictures);
            description.json["pictures"] = {{"folder", options.pictures.string()}, {"count", pictures}};
        }
        std::fputs(report(options, description).c_str(), stdout);
        // A file that was cut is explained; a server that failed in the middle has failed here too.
        if (!is_url(options.source))
            return;
        if (const std::string cut = description.json.value("truncation", ""); !cut.empty())
            throw WorkError(cut);
    };
}

}  // namespace

}  // namespace equistream

int main(int argc, char** argv) {
    equistream::Options options;
    options.command = equistream::cli::quoted_command(argc, argv);
    return equistream::cli::run_program(
        argc, argv,
        {"info", "Explain a stream, an EXR frame or a folder of frames", "equistream info sponza.mkv --frames"},
        [&](equistream::cli::CommandLine& app) { return equistream::set_up(app, options); });
}
