#pragma once
/// The first visible surface along a ray: null surfaces and the holes of masks are no surfaces, glass is one.
#include "shape_facts.h"

#include <drjit/while_loop.h>

namespace equistream::mitsuba_host {

template <typename Float, typename Spectrum>
struct FirstSurface {
    MI_IMPORT_TYPES(Scene, BSDF, BSDFPtr)

    SurfaceInteraction3f si;
    Float distance;  ///< from the ray's origin; +inf for a miss

    /// `ray` with or without differentials; it is not moved, so distances add up along one straight line.
    FirstSurface(const Scene* scene, const RayDifferential3f& ray, const ShapeFacts<Float, Spectrum>& facts,
                 Mask active) {
        Float passed = 0.f;
        if (facts.nothing_passes()) {
            hit_ = scene->ray_intersect_preliminary(ray, true, active);
            rest_ = ray;
        } else {
            passed = pass_through(scene, ray, facts, active);
        }
        si = with_flags(+mitsuba::RayFlags::All, active);
        distance = dr::select(si.is_valid(), passed + si.t, dr::Infinity<Float>);
    }

    /// The same point, with what these of mitsuba::RayFlags ask for.
    SurfaceInteraction3f with_flags(uint32_t flags, Mask active) const {
        PreliminaryIntersection3f hit(hit_);  // Mitsuba asks for one that may change
        return hit.compute_surface_interaction(rest_, flags, active);
    }

private:
    /// Finds the hit and its own ray; returns how far along the ray that one begins.
    Float pass_through(const Scene* scene, const RayDifferential3f& ray, const ShapeFacts<Float, Spectrum>& facts,
                       Mask active) {
        struct LoopState {
            Float passed;
            PreliminaryIntersection3f hit;
            Mask active;
            UInt32 layers;
            DRJIT_STRUCT(LoopState, passed, hit, active, layers)
        };
        LoopState state{0.f, dr::zeros<PreliminaryIntersection3f>(), active, 0u};
        dr::tie(state) = dr::while_loop(
            dr::make_tuple(state), [](const LoopState& s) { return s.active; },
            [scene, &ray, &facts](LoopState& s) {
                const Ray3f rest = rest_of(ray, s.passed);
                s.hit = scene->ray_intersect_preliminary(rest, true, s.active);
                s.active &= s.hit.is_valid();
                const SurfaceInteraction3f here =
                    s.hit.compute_surface_interaction(rest, +mitsuba::RayFlags::All, s.active);
                s.active &= passes_through(here, facts, s.active);
                // A step that shrinks to nothing beside the coordinates would meet the same surface for ever.
                const Float step = (1.f + dr::max(dr::abs(here.p))) * mitsuba::math::RayEpsilon<Float>;
                dr::masked(s.passed, s.active) += s.hit.t + step;
                s.layers += 1u;
                s.active &= s.layers < max_layers;
            },
            "First visible surface");
        rest_ = rest_of(ray, state.passed);
        hit_ = state.hit;
        return state.passed;
    }

    static Ray3f rest_of(const RayDifferential3f& ray, const Float& passed) {
        Ray3f rest(ray);
        rest.o = dr::fmadd(ray.d, passed, ray.o);
        rest.maxt = ray.maxt - passed;
        return rest;
    }

    static Mask passes_through(const SurfaceInteraction3f& here, const ShapeFacts<Float, Spectrum>& facts,
                               const Mask& active) {
        const UInt32 passage = facts.passage(here.shape, active);
        const Mask asks = active && passage == uint32_t(by_opacity);
        Mask result = passage == uint32_t(passes);
        if (dr::any_or<true>(asks)) {
            BSDFPtr bsdf = here.bsdf();
            result |= asks && bsdf->eval_attribute_1(std::string("opacity"), here, asks) < 0.5f;
        }
        return result;
    }

    static constexpr uint32_t max_layers = 4096;

    PreliminaryIntersection3f hit_;
    Ray3f rest_;
};

}  // namespace equistream::mitsuba_host
