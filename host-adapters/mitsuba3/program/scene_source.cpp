#include "scene_source.h"

#include "own_scene.h"
#include "xml_scene.h"

namespace equistream::mitsuba_host {

std::unique_ptr<SceneSource> open_scene(const LoadContext& context) {
    if (context.options.scene.extension() == ".xml")
        return std::make_unique<XmlScene>(context);
    return std::make_unique<OwnScene>(context);
}

}  // namespace equistream::mitsuba_host
