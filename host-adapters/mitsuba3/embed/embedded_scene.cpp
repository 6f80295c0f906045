#include "embedded_scene.h"

#include "edited_xml.h"
#include "invoke_variant.h"

#include <equistream/error.h>

#include <host-adapters/mitsuba3/plugins/version_check.h>

#include <mitsuba/core/appender.h>
#include <mitsuba/core/formatter.h>
#include <mitsuba/core/fresolver.h>
#include <mitsuba/core/logger.h>
#include <mitsuba/core/profiler.h>
#include <mitsuba/core/spectrum.h>
#include <mitsuba/core/thread.h>
#include <mitsuba/core/util.h>
#include <mitsuba/render/scene.h>
#include <nanothread/nanothread.h>

#include <algorithm>
#include <cstdio>
#include <iterator>

namespace equistream::mitsuba_host {

// Of variant_*.cpp.
template <typename Float, typename Spectrum>
std::unique_ptr<EmbeddedScene> make_variant_scene(mitsuba::ref<mitsuba::Object> root, const EditedXml& xml,
                                                  const SceneRequest& request);

std::unique_ptr<EmbeddedScene> EmbeddedScene::load(const Engine& engine, const SceneRequest& request) {
    EditedXml xml = read_and_edit(request, engine.variant());
    try {
        auto objects = mitsuba::parser::instantiate(xml.config, xml.state);
        if (objects.size() != 1)
            throw std::runtime_error(expected_found(request.xml.string(), "one scene", std::to_string(objects.size())));
        return invoke_variant(engine.variant(), [&](auto v) {
            return make_variant_scene<typename decltype(v)::Float, typename decltype(v)::Spectrum>(objects[0], xml,
                                                                                                   request);
        });
    } catch (const std::exception& problem) {
        throw InputError(quotable(one_line(problem.what()), 900));
    }
}

namespace {

struct KnownVariant {
    const char* name;
    JitBackend backend;  // None: scalar
};

constexpr KnownVariant known[] = {
#if defined(EQUISTREAM_LLVM_AD_RGB)
    {"llvm_ad_rgb", JitBackend::LLVM},
#endif
    {"scalar_rgb", JitBackend::None},
#if defined(EQUISTREAM_LLVM_AD_SPECTRAL)
    {"llvm_ad_spectral", JitBackend::LLVM},
#endif
#if defined(EQUISTREAM_LLVM_AD_SPECTRAL_POLARIZED)
    {"llvm_ad_spectral_polarized", JitBackend::LLVM},
#endif
#if defined(EQUISTREAM_SCALAR_SPECTRAL)
    {"scalar_spectral", JitBackend::None},
#endif
#if defined(EQUISTREAM_SCALAR_SPECTRAL_POLARIZED)
    {"scalar_spectral_polarized", JitBackend::None},
#endif
#if defined(EQUISTREAM_CUDA_AD_RGB)
    {"cuda_ad_rgb", JitBackend::CUDA},
#endif
#if defined(EQUISTREAM_CUDA_AD_SPECTRAL)
    {"cuda_ad_spectral", JitBackend::CUDA},
#endif
#if defined(EQUISTREAM_CUDA_AD_SPECTRAL_POLARIZED)
    {"cuda_ad_spectral_polarized", JitBackend::CUDA},
#endif
};

/// Mitsuba writes what it has to say to standard output, where reports go; warnings belong to standard error.
class ErrorStreamAppender : public mitsuba::Appender {
public:
    void append(mitsuba::LogLevel level, std::string_view text) override {
        if (level >= mitsuba::Warn)
            std::fprintf(stderr, "equistream render: note: mitsuba: %s\n", one_line(std::string(text)).c_str());
    }
    void log_progress(float, std::string_view, std::string_view, std::string_view, const void*) override {}
};

/// The text alone: no time, thread, file and line.
class PlainFormatter : public mitsuba::Formatter {
public:
    std::string format(mitsuba::LogLevel, const char*, const char*, int, std::string_view message) override {
        return std::string(message);
    }
};

bool load_backend(JitBackend backend) {
    if (backend == JitBackend::None)
        return true;
    jit_init(1u << static_cast<std::uint32_t>(backend));
    return jit_has_backend(backend) != 0;
}

const KnownVariant& find_variant(const std::string& name) {
    const auto found = std::find_if(std::begin(known), std::end(known), [&](const auto& v) { return v.name == name; });
    if (found != std::end(known))
        return *found;
    if (name.find("_mono") != std::string::npos)
        throw InputError(expected_found("--variant", "a colour variant: " + known_variants(), "'" + name + "'"));
    throw InputError(expected_found("--variant", "one of " + known_variants(), "'" + name + "'"));
}

}  // namespace

std::string known_variants() {
    std::string names;
    for (const KnownVariant& variant : known)
        names += (names.empty() ? "" : ", ") + std::string(variant.name);
    return names;
}

std::string Engine::release() {
    return release_in(mitsuba::util::info_build(1));
}

Engine::Engine(const EngineOptions& options) {
    if (release() != MI_VERSION)
        throw InputError(
            expected_found("libmitsuba.so", "Mitsuba " MI_VERSION ", for which this program was compiled", release()));
    if (!options.variant.empty())
        find_variant(options.variant);
    mitsuba::Thread::static_initialization();
    mitsuba::Logger::static_initialization();
    mitsuba::logger()->clear_appenders();
    mitsuba::logger()->add_appender(new ErrorStreamAppender);
    mitsuba::logger()->set_formatter(new PlainFormatter);
    mitsuba::logger()->set_log_level(mitsuba::Warn);
    jit_set_log_level_stderr(::LogLevel::Error);
    if (options.threads > 0)
        pool_set_size(nullptr, options.threads - 1);
    variant_ = options.variant.empty() ? known[0].name : options.variant;
    const KnownVariant& chosen = find_variant(variant_);
    if (!load_backend(chosen.backend)) {
        if (!options.variant.empty())
            throw InputError(expected_found("--variant " + variant_,
                                            chosen.backend == JitBackend::LLVM
                                                ? "libLLVM (libllvm19, or DRJIT_LIBLLVM_PATH=FILE)"
                                                : "an NVIDIA driver and GPU",
                                            "none that loads"));
        std::fprintf(stderr,
                     "equistream render: note: %s needs libLLVM (libllvm19, or DRJIT_LIBLLVM_PATH=FILE), and "
                     "none loads; rendering with scalar_rgb, which is slower\n",
                     variant_.c_str());
        variant_ = "scalar_rgb";
    }
    const JitBackend backend = find_variant(variant_).backend;
    mitsuba::Profiler::static_initialization();
    mitsuba::color_management_static_initialization(backend == JitBackend::CUDA, backend == JitBackend::LLVM);
    invoke_variant(variant_, [](auto v) {
        mitsuba::Scene<typename decltype(v)::Float, typename decltype(v)::Spectrum>::static_accel_initialization();
    });
    mitsuba::FileResolver& resolver = *mitsuba::file_resolver();
    resolver.append(mitsuba::util::library_path().parent_path());
    resolver.append(options.plugin_root.string());
}

Engine::~Engine() {
    mitsuba::Thread::wait_for_tasks();
    invoke_variant(variant_, [](auto v) {
        mitsuba::Scene<typename decltype(v)::Float, typename decltype(v)::Spectrum>::static_accel_shutdown();
    });
    mitsuba::color_management_static_shutdown();
    mitsuba::Profiler::static_shutdown();
    mitsuba::Logger::static_shutdown();
    mitsuba::Thread::static_shutdown();
    if (find_variant(variant_).backend != JitBackend::None)
        jit_shutdown();
}

}  // namespace equistream::mitsuba_host
