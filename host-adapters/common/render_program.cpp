#include "follow.h"
#include "host.h"
#include "scene_notes.h"
#include "sequence_renderer.h"

#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/threads.h>
#include <programs/cli/process.h>

#include <cstdio>

namespace equistream::render_command {
namespace {

void render(RenderHost& host, RenderOptions options, const std::string& command) {
    if (es_abi_version() != ES_ABI_VERSION)
        throw InputError(expected_found("libequistream", "ABI version " + std::to_string(ES_ABI_VERSION),
                                        std::to_string(es_abi_version())));
    if (options.samples_by_angle && !host.fills_tiles())
        throw InputError(
            expected_found("--samples", "even: " + host.text().name + " renders whole pictures", "'angle'"));
    if (options.part.count > 0 && !host.fills_tiles())
        throw InputError(expected_found("--part", "none: " + host.text().name + " renders whole pictures",
                                        std::to_string(options.part.count) + " parts"));
    if (options.threads == 0)
        options.threads = usable_processors();
    RenderReport report;
    report.threads = options.threads;
    const auto start = Clock::now();
    const SceneDescription& scene = host.describe(options);
    const Timeline timeline = make_timeline(options, scene);
    for (const std::string& note : scene_notes(scene, timeline.path))
        std::fprintf(stderr, "equistream render: note: %s\n", note.c_str());
    if (options.dry_run)
        return print_plan(options, timeline, host, command);
    host.load(options, timeline);
    report.load_s = seconds_since(start);
    const RenderRecord record{host.record(), host.tile_side(), command, host.names()};
    if (options.follow) {
        host.begin();
        cli::note_interrupts();
        return follow({options, scene, timeline, record, cli::interrupted()}, host);
    }
    std::vector<Stream> streams;
    if (host.wants_frames())
        streams = StreamOpener(options, scene, timeline.path, record).all();
    host.begin();
    if (host.wants_frames()) {
        cli::note_interrupts();
        SequenceRenderer({options, timeline, scene.head_radius_m, streams, cli::interrupted()}, host, report).run();
    }
    print_report(report, host, command, options.json);
}

}  // namespace

int run(int argc, char** argv, RenderHost& host) {
    const HostText text = host.text();
    return cli::run_program(
        argc, argv, {"render", text.summary, text.example}, [&](cli::CommandLine& app) -> std::function<void()> {
            const auto options = add_render_options(app, text);
            host.add_options(app);
            cli::end_where_memory_ends("render");
            return [&host, argc, argv, options] { render(host, options(), cli::quoted_command(argc, argv)); };
        });
}

}  // namespace equistream::render_command
