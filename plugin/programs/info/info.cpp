/// equistream info: explains any file of ours.
#include "describe.h"
#include "pictures.h"

#include <equistream/error.h>
#include <equistream/json_text.h>
#include <equistream/stream.h>
#include <equistream_cli/program.h>

#include <cstdio>
#include <fstream>

namespace equistream {

namespace {

struct Options {
    std::string source;
    bool json = false;
    bool frames = false;
    std::filesystem::path pictures;
};

bool is_exr(const std::string& file) {
    constexpr unsigned char magic[] = {0x76, 0x2f, 0x31, 0x01};
    char start[4] = {};
    std::ifstream(file, std::ios::binary).read(start, sizeof start);
    return std::equal(std::begin(magic), std::end(magic), start,
                      [](unsigned char a, char b) { return a == static_cast<unsigned char>(b); });
}

Description describe(const Options& options) {
    const bool url = is_url(options.source);
    if (!url && !std::filesystem::exists(options.source))
        throw InputError(options.source + ": no such file or folder");
    if (!url && std::filesystem::is_directory(options.source))
        return describe_folder(options.source, {options.frames});
    if (!url && is_exr(options.source))
        return describe_exr(options.source);
    return describe_stream(options.source, {options.frames});
}

std::function<void()> set_up(CLI::App& app, Options& options) {
    app.add_option("SOURCE", options.source, "A stream (file or URL), an EXR frame, or a folder of frames")->required();
    app.add_flag("--json", options.json, "Report as JSON");
    app.add_flag("--frames", options.frames, "List every frame with its pose");
    app.add_option("--pictures", options.pictures,
                   "Also write a PNG of every plane (depth, motion, ids, ... in false colours) into this folder");
    return [&options] {
        if (!options.pictures.empty())
            write_pictures(options.source, options.pictures);
        const Description description = describe(options);
        std::fputs(options.json ? (json_text(description.json, 2) + "\n").c_str() : description.text.c_str(), stdout);
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
    return equistream::cli::run_program(
        argc, argv,
        {"info", "Explain a stream, an EXR frame or a folder of frames", "equistream info sponza.mkv --frames"},
        [&](CLI::App& app) { return equistream::set_up(app, options); });
}
