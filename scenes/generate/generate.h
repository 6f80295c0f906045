#pragma once
/// The bundled scenes: made by formula, the same bytes every time, so that nothing has to be downloaded.
#include <scenes/library/model.h>
#include <scenes/library/scene.h>

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace equistream {

/// One knob of a generated scene.
struct GeneratorOption {
    std::string_view name;
    std::string_view default_value;
    std::string_view meaning;
};

/// Values of a scene's options by name; every option of its table entry has one.
class GeneratorValues {
public:
    explicit GeneratorValues(std::map<std::string, std::string, std::less<>> values) : values_(std::move(values)) {}
    /// Each throws InputError naming the option, what was expected and what was found.
    double number(std::string_view name, double low, double high) const;
    int count(std::string_view name, int low, int high) const;
    const std::string& word(std::string_view name, std::span<const std::string_view> accepted) const;

private:
    std::map<std::string, std::string, std::less<>> values_;
};

/// A model and what its description says of it. description.file, model and fingerprint are empty until it is written.
struct GeneratedScene {
    SceneModel model;
    SceneDescription description;
};

struct Generator {
    std::string_view name;
    std::string_view summary;
    std::span<const GeneratorOption> options;
    GeneratedScene (*make)(const GeneratorValues&);
};

/// The table behind `equistream scene generate` and its --list.
std::span<const Generator> generators();
/// Throws InputError with the accepted names.
const Generator& find_generator(std::string_view name);

/// Runs a generator. `settings` are "option=value"; the others take their defaults.
GeneratedScene make_scene(const Generator& generator, std::span<const std::string> settings = {});

/// The sun, the sky and the exposure of a clear day.
void add_daylight(SceneDescription& description);

/// Writes NAME.glb, then NAME.json (each whole or not at all), into `folder`, which is made if need be. Returns the
/// description's path. Throws InputError where nothing can be written there.
std::filesystem::path write_scene(const GeneratedScene& scene, const std::filesystem::path& folder);

}  // namespace equistream
