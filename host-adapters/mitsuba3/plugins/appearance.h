#pragma once
/// What a surface looks like whatever the light: its albedo, and whether it mirrors or refracts sharply.
#include "first_surface.h"

#include <equistream/virtual_image.h>

#include <drjit/while_loop.h>
#include <mitsuba/render/bsdf.h>
#include <mitsuba/render/interaction.h>
#include <mitsuba/render/texture.h>

namespace equistream::mitsuba_host {

template <typename Float, typename Spectrum>
class Appearance {
public:
    MI_IMPORT_TYPES(BSDF, BSDFPtr, Texture)

    Appearance() {
        if constexpr (mitsuba::is_spectral_v<Spectrum>)
            daylight_ = Texture::D65();
    }

    /// Diffuse albedo in linear Rec.709; of a surface without a diffuse lobe, what it reflects or lets through at
    /// normal incidence. `may_lack_diffuse` says whether the scene has such surfaces at all.
    Color3f albedo(const BSDFPtr& bsdf, const SurfaceInteraction3f& si, bool may_lack_diffuse, Mask active) const {
        Color3f rgb(0.f);
        if constexpr (mitsuba::is_spectral_v<Spectrum>) {
            // Seen in daylight, and a white surface divided out: RGB reflectances come back as they were given.
            constexpr uint32_t sets = 8;
            Color3f white(0.f);
            SurfaceInteraction3f lit(si);
            for (uint32_t i = 0; i < sets; ++i) {
                lit.wavelengths = wavelengths((Float(ScalarFloat(i)) + 0.5f) / ScalarFloat(sets));
                const UnpolarizedSpectrum light = daylight_->eval(lit, active);
                rgb += mitsuba::spectrum_to_srgb(reflectance(bsdf, lit, may_lack_diffuse, active) * light,
                                                 lit.wavelengths, active);
                white += mitsuba::spectrum_to_srgb(light, lit.wavelengths, active);
            }
            rgb /= dr::maximum(white, 1e-6f);
        } else {
            const UnpolarizedSpectrum value = reflectance(bsdf, si, may_lack_diffuse, active);
            if constexpr (mitsuba::is_monochromatic_v<Spectrum>)
                rgb = Color3f(value.x());
            else
                rgb = value;
        }
        return dr::select(active && dr::isfinite(rgb), dr::maximum(rgb, 0.f), 0.f);
    }

    /// What a surface does to a ray when it is sharp.
    struct SharpLobe {
        Mask sharp;  ///< min_sharp_share of what it sends on leaves in delta lobes, or in glossy ones as sharp as GGX
                     ///< of alpha 0.05: half of whose microfacet normals are within that slope of the surface's
        Mask transmits;  ///< of that, more is let through than mirrored
        Float eta;       ///< index of refraction there over here, for what is let through
    };
    SharpLobe sharp_lobe(const BSDFPtr& bsdf, const SurfaceInteraction3f& si, Mask active) const {
        struct LoopState {
            UInt32 i;
            Float total, delta, glossy, glossy_count, sharp_count, delta_through, glossy_through, eta;
            DRJIT_STRUCT(LoopState, i, total, delta, glossy, glossy_count, sharp_count, delta_through, glossy_through,
                         eta)
        };
        SurfaceInteraction3f lit(si);
        if constexpr (mitsuba::is_spectral_v<Spectrum>)
            lit.wavelengths = wavelengths(Float(0.5f));
        const Vector3f normal = lit.to_local(bsdf->sh_frame(lit, active).n);
        LoopState state{0u, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 1.f};
        dr::tie(state) = dr::while_loop(
            dr::make_tuple(state), [](const LoopState& s) { return s.i < sample_count; },
            [&bsdf, &lit, &normal, active](LoopState& s) {
                using mitsuba::BSDFFlags;
                const Float i = Float(s.i);
                const Point2f u(fraction(dr::fmadd(i, 0.7548776662f, 0.5f)),
                                fraction(dr::fmadd(i, 0.5698402910f, 0.5f)));
                auto [sample, weight] =
                    bsdf->sample(mitsuba::BSDFContext(), lit, (i + 0.5f) / ScalarFloat(sample_count), u, active);
                const Float energy = dr::select(sample.pdf > 0.f, mean(weight), 0.f);
                const Mask is_delta = mitsuba::has_flag(sample.sampled_type, BSDFFlags::Delta) ||
                                      mitsuba::has_flag(sample.sampled_type, BSDFFlags::Null);
                const Mask is_glossy = mitsuba::has_flag(sample.sampled_type, BSDFFlags::Glossy) && energy > 0.f;
                s.total += energy;
                dr::masked(s.delta, is_delta) += energy;
                dr::masked(s.glossy, is_glossy) += energy;
                const Mask through = energy > 0.f && lit.wi.z() * sample.wo.z() < 0.f;
                dr::masked(s.delta_through, is_delta && through) += energy;
                dr::masked(s.glossy_through, is_glossy && through) += energy;
                dr::masked(s.eta, (is_delta || is_glossy) && through) = sample.eta;
                dr::masked(s.glossy_count, is_glossy) += 1.f;
                dr::masked(s.sharp_count, is_glossy && slope(lit.wi, sample.wo, sample.eta, normal) <= sharpest) += 1.f;
                s.i += 1u;
            },
            "Specular lobes");
        const Mask narrow = 2.f * state.sharp_count >= state.glossy_count;
        const Float sharp = state.delta + dr::select(narrow, state.glossy, 0.f);
        const Float through = state.delta_through + dr::select(narrow, state.glossy_through, 0.f);
        return {active && sharp > min_sharp_share * state.total, 2.f * through >= sharp && through > 0.f, state.eta};
    }

private:
    static constexpr uint32_t sample_count = 16;
    static constexpr ScalarFloat sharpest = 0.05f;

    static Wavelength wavelengths(const Float& sample) {
        if constexpr (mitsuba::is_spectral_v<Spectrum>)
            return mitsuba::math::sample_shifted<Wavelength>(sample) * ScalarFloat(MI_CIE_MAX - MI_CIE_MIN) +
                   ScalarFloat(MI_CIE_MIN);
        else
            return {};
    }

    static Float mean(const Spectrum& value) { return dr::mean(mitsuba::unpolarized_spectrum(value)); }

    static Float fraction(const Float& x) { return x - dr::floor(x); }

    /// Tangent of the angle between a microfacet that sends wi to wo and the surface.
    static Float slope(const Vector3f& wi, const Vector3f& wo, const Float& eta, const Vector3f& normal) {
        const Mask reflected = wi.z() * wo.z() > 0.f;
        // Thin sheets mirror first and let through then.
        const Mask thin = !reflected && dr::abs(eta - 1.f) < 1e-4f;
        const Vector3f out = dr::select(thin, Vector3f(wo.x(), wo.y(), -wo.z()), wo);
        const Vector3f half = dr::normalize(dr::fmadd(out, dr::select(reflected || thin, 1.f, eta), wi));
        const Float cosine = dr::abs(dr::dot(half, normal));
        return dr::safe_sqrt(1.f - cosine * cosine) / cosine;
    }

    static UnpolarizedSpectrum reflectance(const BSDFPtr& bsdf, const SurfaceInteraction3f& si, bool may_lack_diffuse,
                                           Mask active) {
        using mitsuba::BSDFFlags;
        UnpolarizedSpectrum value = mitsuba::unpolarized_spectrum(bsdf->eval_diffuse_reflectance(si, active));
        if (!may_lack_diffuse)
            return value;
        const Mask lacks = active && !mitsuba::has_flag(bsdf->flags(active), BSDFFlags::Diffuse);
        if (dr::none_or<false>(lacks))
            return value;
        SurfaceInteraction3f ahead(si);
        ahead.wi = Vector3f(0.f, 0.f, dr::select(si.wi.z() < 0.f, Float(-1.f), Float(1.f)));
        // Importance has no factor for the change of solid angle at a refraction.
        auto [sample, weight] =
            bsdf->sample(mitsuba::BSDFContext(mitsuba::TransportMode::Importance), ahead, 0.5f, Point2f(0.5f), lacks);
        return dr::select(lacks, mitsuba::unpolarized_spectrum(weight), value);
    }

    mitsuba::ref<Texture> daylight_;
};

// What guides a denoiser: albedo and normal of the first surface along a ray that is not sharp, seen through mirrors
// and glass by the lobe that sends the most; of what shines its radiance instead, at most 1.

template <typename Float, typename Spectrum>
class GuideRay {
public:
    MI_IMPORT_TYPES(Scene, BSDFPtr, EmitterPtr)
    using Facts = ShapeFacts<Float, Spectrum>;

    Mask hit;  ///< the first surface, sharp or not
    Color3f albedo;
    Vector3f normal;

    GuideRay(const Scene* scene, const Facts& facts, const Appearance<Float, Spectrum>& appearance,
             const RayDifferential3f& ray, const Mask& active) {
        State state{ray.o, ray.d, Color3f(0.f), Vector3f(0.f), 0u, false, active};
        dr::tie(state) = dr::while_loop(
            dr::make_tuple(state), [](const State& s) { return s.active; },
            [scene, &facts, &appearance, &ray](State& s) { follow(scene, facts, appearance, ray, s); },
            "What guides a denoiser");
        hit = state.hit;
        albedo = state.albedo;
        normal = state.normal;
    }

private:
    struct State {
        Point3f origin;
        Vector3f direction;
        Color3f albedo;
        Vector3f normal;
        UInt32 surfaces;
        Mask hit, active;
        DRJIT_STRUCT(State, origin, direction, albedo, normal, surfaces, hit, active)
    };

    static void follow(const Scene* scene, const Facts& facts, const Appearance<Float, Spectrum>& appearance,
                       const RayDifferential3f& first, State& s) {
        RayDifferential3f ray(s.origin, s.direction, first.time, first.wavelengths);
        dr::masked(ray.maxt, s.surfaces == 0u) = first.maxt;
        const FirstSurface<Float, Spectrum> surface(scene, ray, facts, s.active);
        const SurfaceInteraction3f& si = surface.si;
        const Mask hit = s.active && si.is_valid();
        s.hit |= hit && s.surfaces == 0u;
        const Color3f shining = radiance(scene, si, s.active);
        dr::masked(s.albedo, s.active && !hit) = shining;
        s.active &= hit;
        if (!dr::any_or<true>(hit))
            return;
        const BSDFPtr bsdf = si.bsdf();
        const Vector3f shading(bsdf->sh_frame(si, hit).n);
        const Vector3f facing = dr::mulsign(shading, -dr::dot(shading, ray.d));
        const Float cosine = dr::dot(ray.d, facing);
        const auto lobe = appearance.sharp_lobe(bsdf, si, hit);
        const Float eta = dr::rcp(lobe.eta), sine2 = eta * eta * (1.f - cosine * cosine);
        const Mask passes = lobe.transmits && sine2 < 1.f;
        const Vector3f mirrored = dr::fnmadd(facing, 2.f * cosine, ray.d);
        const Vector3f refracted = eta * ray.d - (eta * cosine + dr::safe_sqrt(1.f - sine2)) * facing;
        const Mask on = hit && lobe.sharp && (passes || !lobe.transmits) && s.surfaces < max_sharp_surfaces;
        dr::masked(s.direction, on) = dr::select(passes, refracted, mirrored);
        dr::masked(s.origin, on) = si.spawn_ray(s.direction).o;
        dr::masked(s.surfaces, on) += 1u;
        const Mask here = hit && !on;
        const Color3f own = appearance.albedo(bsdf, si, facts.any_without_diffuse(), here);
        dr::masked(s.albedo, here) = dr::minimum(dr::maximum(own, shining), 1.f);
        dr::masked(s.normal, here) = facing;
        s.active &= on;
    }

    static Color3f radiance(const Scene* scene, const SurfaceInteraction3f& si, const Mask& active) {
        Color3f rgb(0.f);
        if constexpr (!mitsuba::is_spectral_v<Spectrum>) {
            const EmitterPtr emitter = si.emitter(scene, active);
            const Mask shines = active && emitter != nullptr;
            if (dr::any_or<true>(shines)) {
                const auto value = mitsuba::unpolarized_spectrum(emitter->eval(si, shines));
                if constexpr (mitsuba::is_monochromatic_v<Spectrum>)
                    rgb = Color3f(value.x());
                else
                    rgb = value;
            }
            rgb = dr::select(shines && dr::isfinite(rgb), dr::clip(rgb, 0.f, 1.f), 0.f);
        }
        return rgb;
    }
};

// What is seen in mirrors and through glass: a ray followed on, at each sharp surface into the lobe that sends the
// most, to the first surface that is not sharp, and where that appears to lie (equistream/virtual_image.h). Surfaces
// below a shape group are taken to be flat: Mitsuba does not tell how those bend.

template <typename Float, typename Spectrum>
class SharpPath {
public:
    MI_IMPORT_TYPES(Scene, BSDF, BSDFPtr)
    using Facts = ShapeFacts<Float, Spectrum>;
    using Surface = FirstSurface<Float, Spectrum>;

    Mask is_sharp;   ///< something else is seen in the first surface
    Mask ends;       ///< and it is a surface
    Point3f seen;    ///< a point of it
    UInt32 shape;    ///< of which one: index in the scene's list
    Float distance;  ///< where it appears to lie; from the eye

    /// The eye is `eye_before` before the ray's origin.
    SharpPath(const Scene* scene, const Facts& facts, const Appearance<Float, Spectrum>& appearance,
              const RayDifferential3f& ray, const Float& eye_before, const Mask& active)
        : eye_(ray.o - ray.d * eye_before), eye_direction_(ray.d), pencil_(Pencil<Float>::from_eye(own(ray.d))) {
        pencil_.travel(eye_before);
        State state = first_state(ray, active);
        dr::tie(state) = dr::while_loop(
            dr::make_tuple(state), [](const State& s) { return s.active; },
            [scene, &facts, &appearance, &ray](State& s) { follow(scene, facts, appearance, ray, s); },
            "What a mirror shows");
        take(state, pencil_);
        is_sharp = active && state.surfaces > 0u;
        ends = is_sharp && state.ends;
        seen = state.seen;
        shape = state.shape;
        distance = pencil_.image_distance(Mask(!ends));
    }

    /// Where the image of the point goes when that moves.
    Point3f image_moved(const Vector3f& movement) const {
        const Float reach = dr::select(dr::isfinite(distance), distance, Float(0.f));
        const Vector3<Float> m = pencil_.image_movement(own(eye_direction_), reach, own(movement));
        return dr::fmadd(eye_direction_, reach, eye_) + Vector3f(m.x, m.y, m.z);
    }

private:
    static constexpr int count = Pencil<Float>::count;

    struct State {
        Point3f origin;  ///< off the surface that it left, by `lead` along the ray
        Vector3f direction;
        Float lead;
        dr::Array<Vector3f, count> position, turn;
        Point3f seen;
        UInt32 shape, surfaces;
        Mask ends, active;
        DRJIT_STRUCT(State, origin, direction, lead, position, turn, seen, shape, surfaces, ends, active)
    };

    static Vector3<Float> own(const Vector3f& v) { return {v.x(), v.y(), v.z()}; }
    static Vector3f theirs(const Vector3<Float>& v) { return {v.x, v.y, v.z}; }

    static void take(const State& state, Pencil<Float>& pencil) {
        pencil.direction = own(state.direction);
        for (size_t i = 0; i < count; ++i) {
            pencil.position[i] = own(state.position[i]);
            pencil.turn[i] = own(state.turn[i]);
        }
    }
    static void give(const Pencil<Float>& pencil, const Mask& where, State& state) {
        dr::masked(state.direction, where) = theirs(pencil.direction);
        for (size_t i = 0; i < count; ++i) {
            dr::masked(state.position[i], where) = theirs(pencil.position[i]);
            dr::masked(state.turn[i], where) = theirs(pencil.turn[i]);
        }
    }

    State first_state(const RayDifferential3f& ray, const Mask& active) const {
        State state;
        state.origin = ray.o;
        state.direction = ray.d;
        state.lead = 0.f;
        for (size_t i = 0; i < count; ++i) {
            state.position[i] = theirs(pencil_.position[i]);
            state.turn[i] = theirs(pencil_.turn[i]);
        }
        state.seen = Point3f(0.f);
        state.shape = state.surfaces = 0u;
        state.ends = false;
        state.active = active;
        return state;
    }

    static void follow(const Scene* scene, const Facts& facts, const Appearance<Float, Spectrum>& appearance,
                       const RayDifferential3f& first, State& s) {
        RayDifferential3f ray(s.origin, s.direction, first.time, first.wavelengths);
        dr::masked(ray.maxt, s.surfaces == 0u) = first.maxt;
        const Surface surface(scene, ray, facts, s.active);
        const SurfaceInteraction3f& si = surface.si;
        const Mask hit = s.active && si.is_valid();
        s.active &= hit;
        if (!dr::any_or<true>(hit))
            return;
        Pencil<Float> pencil{};
        take(s, pencil);
        pencil.travel(dr::select(hit, surface.distance + s.lead, Float(0.f)));
        give(pencil, hit, s);

        const BSDFPtr bsdf = si.bsdf();
        const auto lobe = appearance.sharp_lobe(bsdf, si, hit);
        const Vector3f geometric = dr::mulsign(Vector3f(si.n), -dr::dot(si.n, ray.d));
        const Vector3f shading(bsdf->sh_frame(si, hit).n);
        const Vector3f normal = dr::mulsign(shading, -dr::dot(shading, ray.d));
        Pencil<Float> mirrored = pencil;
        mirrored.onto_surface(own(geometric));
        Vector3<Float> bend[count];
        bends(surface, normal, mirrored, hit, bend);
        Pencil<Float> refracted = mirrored;
        mirrored.reflect(own(normal), bend);
        const Mask straight = dr::abs(lobe.eta - 1.f) < 1e-4f;
        const Float eta = dr::rcp(lobe.eta), cosine = dr::dot(ray.d, normal);
        const Mask passes = lobe.transmits && eta * eta * (1.f - cosine * cosine) < 1.f;
        refracted.refract(own(normal), bend, eta);

        const Mask returns = !lobe.transmits && dr::dot(theirs(mirrored.direction), geometric) > 0.f;
        const Mask on = hit && lobe.sharp && (returns || passes) && s.surfaces < max_sharp_surfaces;
        give(mirrored, on && returns, s);
        give(refracted, on && passes && !straight, s);
        const Point3f origin = si.spawn_ray(s.direction).o;
        dr::masked(s.origin, on) = origin;
        dr::masked(s.lead, on) = dr::dot(origin - si.p, s.direction);
        dr::masked(s.surfaces, on) += 1u;
        const Mask here = hit && !on;
        dr::masked(s.seen, here) = si.p;
        dr::masked(s.shape, here) = facts.index(si.shape, si.instance, here);
        s.ends |= here;
        s.active &= on;
    }

    /// Derivatives of the normal, which faces the viewer, for the pencil's movements within the surface.
    static void bends(const Surface& surface, const Vector3f& normal, const Pencil<Float>& pencil, const Mask& active,
                      Vector3<Float> (&bend)[count]) {
        // Without texture coordinates: a mesh's derivatives of places would be by those, of normals by barycentrics.
        const SurfaceInteraction3f si =
            surface.with_flags(mitsuba::RayFlags::ShadingFrame | mitsuba::RayFlags::dNSdUV, active);
        const Float uu = dr::dot(si.dp_du, si.dp_du), uv = dr::dot(si.dp_du, si.dp_dv),
                    vv = dr::dot(si.dp_dv, si.dp_dv);
        const Float determinant = dr::fmsub(uu, vv, uv * uv);
        const Mask known = active && determinant > 0.f && si.instance == nullptr;
        // A mesh whose normals are flipped keeps the derivatives of those that it had.
        const Mask flipped = si.shape->is_mesh() && si.shape->has_flipped_normals();
        const Float side =
            dr::mulsign(dr::select(flipped, Float(-1.f), Float(1.f)), dr::dot(Vector3f(si.sh_frame.n), normal));
        const Float scale = dr::select(known, side / determinant, Float(0.f));
        for (int i = 0; i < count; ++i) {
            const Vector3f moved = theirs(pencil.position[i]);
            const Float u = dr::dot(moved, si.dp_du), v = dr::dot(moved, si.dp_dv);
            const Vector3f change = (vv * u - uv * v) * Vector3f(si.dn_du) + (uu * v - uv * u) * Vector3f(si.dn_dv);
            bend[i] = own(dr::select(known, change * scale, Vector3f(0.f)));
        }
    }

    Point3f eye_;
    Vector3f eye_direction_;
    Pencil<Float> pencil_;
};

}  // namespace equistream::mitsuba_host
