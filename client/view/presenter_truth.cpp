/// Path-traced eyes beside what is drawn.
#include "presenter.h"

#include <client/compare/picture_metrics.h>
#include <client/warp/engine.h>
#include <equistream/formatted.h>

#include <cmath>
#include <utility>

namespace equistream {

/// Whether there is another one to be seen, or none any more. What cannot be read is told once.
bool Presenter::find_truth() {
    if (truth_ == nullptr)
        return false;
    const Eye eye = settings_.layout == gl::DisplayLayout::right ? Eye::right : Eye::left;
    Truth::Found found = truth_->at(frame().main.info.time_s, eye);
    truth_is_coming_ = found.is_coming;
    if (!found.problem.empty() && found.problem != truth_problem_)
        tell(found.problem);
    truth_problem_ = std::move(found.problem);
    const bool is_other = found.eye != true_eye_;
    true_eye_ = std::move(found.eye);
    // While it comes the head stays: it does not go to the frame's own and back.
    if (true_eye_ || !truth_is_coming_ || report_.frames == 0)
        followed_.show(true_eye_ ? true_eye_->head : frame().main.info.head);
    return is_other;
}

/// Empty: the truth is of what is drawn.
std::string Presenter::why_no_truth() const {
    if (settings_.layout != gl::DisplayLayout::right && settings_.layout != gl::DisplayLayout::left)
        return "the truth is shown beside one eye (v)";
    if (!truth_problem_.empty())
        return truth_problem_;
    // A folder may hold fewer frames than are watched, and one eye of the two: said on the screen, as all of these are.
    if (!true_eye_)
        return truth_is_coming_ ? "the truth is being read" : "there is no truth of this eye at this time";
    const PerspectiveCamera& camera = true_eye_->camera;
    if (!(inputs_.window == gl::Size{camera.width, camera.height}))
        return formatted("the truth is %dx%d: the window must be", camera.width, camera.height);
    if (std::abs(fov_deg_ - camera.fov_x_rad * 180 / pi) > 1e-6)
        return formatted("the truth is %s degrees wide: the view must be",
                         in_words(camera.fov_x_rad * 180 / pi).c_str());
    if (std::abs(ipd_m() - true_eye_->ipd_m) > 1e-6)
        return formatted("the truth's eyes are %s m apart: the view's must be", in_words(true_eye_->ipd_m).c_str());
    if (!same_pose(seen_head_, {}))
        return "the head is not where the truth is (c: back)";
    return "";
}

bool Presenter::shows_truth() const {
    return truth_ != nullptr && split_ < 1 && why_no_truth().empty();
}

/// Where the other method would be, and how near what is drawn is to it.
void Presenter::put_truth_beside() {
    const ByteImage& rgb = true_eye_->rgb;
    other_targets_.size_for(true_eye_->camera, 1);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTextureSubImage3D(other_targets_.colour(), 0, 0, 0, 0, rgb.width(), rgb.height(), 1, GL_RGB, GL_UNSIGNED_BYTE,
                        rgb.samples().data());
    targets_.download(0, seen_);
    truth_db_ = total_error(squared_errors(seen_.rgb().view(), rgb.view())).psnr_db();
    report_.truth_db = report_.truth_db.value_or(0) + *truth_db_;
    ++truth_count_;
}

}  // namespace equistream
