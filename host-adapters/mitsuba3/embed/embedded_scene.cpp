#include "embedded_scene.h"

#include "edited_xml.h"
#include "invoke_variant.h"
#include "one_line.h"

#include <equistream/error.h>

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

}  // namespace equistream::mitsuba_host
