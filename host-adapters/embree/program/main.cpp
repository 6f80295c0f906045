#include "render.h"

#include <equistream_cli/program.h>

int main(int argc, char** argv) {
    using namespace equistream;
    return cli::run_program(
        argc, argv,
        {"render", "Path traces a scene along a camera path into EXR sequences.",
         "equistream render pavilion.json --size 960x480 --frames 0-7 --eye centre --small right --out frames"},
        [&](CLI::App& app) -> std::function<void()> {
            const auto options = embree_host::add_render_options(app);
            return [&, options] { embree_host::render(options(), cli::quoted_command(argc, argv)); };
        });
}
