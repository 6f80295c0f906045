#pragma once
/// Whether rays meet a surface, as alpha: what a frame's colour says of itself. Mitsuba's path integrator calls the sky
/// a hit, and its depth integrator the holes of masks.
#include <host-adapters/mitsuba3/plugins/first_surface.h>

#include <mitsuba/core/properties.h>
#include <mitsuba/render/integrator.h>

#include <optional>

namespace equistream::mitsuba_host {

template <typename Float, typename Spectrum>
class HitIntegrator final : public mitsuba::SamplingIntegrator<Float, Spectrum> {
public:
    using Base = mitsuba::SamplingIntegrator<Float, Spectrum>;
    MI_IMPORT_TYPES(Scene, Sensor, Medium, Sampler)

    explicit HitIntegrator(bool hides_emitters)
        : Base(mitsuba::Properties("equistream_hits")), hides_emitters_(hides_emitters) {}

    TensorXf render(Scene* scene, Sensor* sensor, UInt32 seed, std::uint32_t spp, bool develop,
                    bool evaluate) override {
        facts_.emplace(scene, hides_emitters_);
        return Base::render(scene, sensor, seed, spp, develop, evaluate);
    }

    std::pair<Spectrum, Mask> sample(const Scene* scene, Sampler*, const RayDifferential3f& ray, const Medium*, Float*,
                                     Mask active) const override {
        const FirstSurface<Float, Spectrum> first(scene, ray, *facts_, active);
        return {Spectrum(0.f), active && first.si.is_valid()};
    }

    MI_DECLARE_CLASS(HitIntegrator)

private:
    bool hides_emitters_;
    std::optional<ShapeFacts<Float, Spectrum>> facts_;
};

}  // namespace equistream::mitsuba_host
