#pragma once
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "axode/io/reading.hpp"
#include "axode/model/building/placement.hpp"

namespace axode::io {

/// Whether a degree of freedom has a finite limit.
inline bool bounded(const Dof& dof) { return std::isfinite(dof.lower) || std::isfinite(dof.upper); }

/// Collects faults about the elements of a mechanism that the format of a writer cannot express.
class Unsaid {
 public:
  Unsaid(std::string_view format, Strictness strictness) : format_(format), strictness_(strictness) {}

  /// Adds a fault, an error if the writer is strict or else a warning, about an element that is left out.
  /// `what` is the predicate of a sentence about it, such as `is passive`.
  void leave_out(std::string element, const std::string& what, const Source& source) {
    const bool strict = strictness_ == Strictness::strict;
    faults_.push_back({strict ? Severity::error : Severity::warning, Rule::wrong_value, std::move(element),
                       what + "; " + format_ + " has no word for it" + (strict ? "" : ", and it is left out"),
                       source});
  }
  /// Adds a fault for each drive, each prescribed motion and the initial state, as all of them are left out.
  void leave_out_motions(const Description& d) {
    for (std::size_t k = 0; k < d.drives.size(); ++k)
      leave_out("drive \"" + drive_name(d.drives[k], k) + '"',
                "is a " + std::string(to_string(d.drives[k].kind)), d.drives[k].source);
    for (const MotionDescription& motion : d.motions)
      leave_out("motion of \"" + motion.of + '"', "is prescribed", motion.source);
    if (d.state) leave_out("state", "is the initial state of motions", d.state->source);
  }
  /// Adds an error about an element without which bodies would move differently, in a lenient writer, too.
  void refuse(std::string element, std::string message, const Source& source) {
    faults_.push_back({Severity::error, Rule::wrong_value, std::move(element), std::move(message), source});
  }

  /// Throws ModelError if there is an error.
  void throw_errors(std::string_view model) {
    if (has_error(faults_)) throw ModelError(model, std::move(faults_));
  }
  /// The collected warnings. Call throw_errors() before, so that no error is among them.
  std::vector<Fault> warnings() && { return std::move(faults_); }

 private:
  std::string format_;
  Strictness strictness_;
  std::vector<Fault> faults_;
};

/// The predicate of a sentence about a spring, such as `is a bushing between "a" and "b"`.
inline std::string said_of(const SpringDescription& spring) {
  const std::string between = "between \"" + spring.between[0] + "\" and \"" + spring.between[1] + '"';
  switch (spring.kind) {
    case SpringKind::line: return "is " + between;
    case SpringKind::tendon: return "is a tendon with " + std::to_string(spring.path.size()) + " points";
    case SpringKind::torsion: return "is a torsion spring " + between;
    case SpringKind::joints: return "acts on coordinates of joints";
    case SpringKind::bushing: return "is a bushing " + between;
  }
  return {};
}

/// Whether a shape has friction, restitution or stiffness of its own.
inline bool has_surface(const ShapeDescription& shape) {
  const ContactProperties& it = shape.contact;
  return it.friction || it.spin_friction != 0 || it.rolling_friction != 0 || it.restitution != 0 ||
         it.stiffness;
}

}  // namespace axode::io
