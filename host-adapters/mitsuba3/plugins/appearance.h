#pragma once
/// What a surface looks like whatever the light: its albedo, and whether it mirrors or refracts sharply.
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

}  // namespace equistream::mitsuba_host
