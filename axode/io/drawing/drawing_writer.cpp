#include <algorithm>
#include <cmath>
#include <ostream>
#include <utility>
#include <variant>

#include "axode/io.hpp"
#include "axode/io/drawing/construction_frame.hpp"
#include "axode/model/kinds/joint_kinds.hpp"
#include "axode/model/kinds/shape_kinds.hpp"
#include "axode/model/loops.hpp"

namespace axode {
namespace {

std::string toml_text(double x) { return to_text(x == 0 ? 0.0 : x); }  // -0 becomes 0
std::string toml_text(std::string_view s) {
  constexpr std::string_view digits = "0123456789ABCDEF";
  std::string out = "\"";
  for (const char c : s) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (byte < 0x20 || byte == 0x7f) {
      out += "\\u00";
      out += digits[byte >> 4];
      out += digits[byte & 15];
    } else {
      out += c;
    }
  }
  return out + '"';
}
std::string toml_text(const std::vector<double>& numbers) {
  std::string out = "[";
  for (const double x : numbers) out += (out.size() > 1 ? ", " : "") + toml_text(x);
  return out + "]";
}
std::string toml_text(const Vec3<>& a) {
  return "[" + toml_text(a.x) + ", " + toml_text(a.y) + ", " + toml_text(a.z) + "]";
}
std::string toml_text(const SO3<>& R) {
  const SO3<> rows = transpose(R);
  return "[" + toml_text(rows.x) + ", " + toml_text(rows.y) + ", " + toml_text(rows.z) + "]";
}
std::string toml_text(const Sym3<>& A) {
  std::string out = "[";
  for (const double x : {A.xx, A.yy, A.zz, A.xy, A.xz}) out += toml_text(x) + ", ";
  return out + toml_text(A.yz) + "]";
}

bool is_identity(const SO3<>& R) {
  const auto is = [](const Vec3<>& a, double x, double y, double z) {
    return a.x == x && a.y == y && a.z == z;
  };
  return is(R.x, 1, 0, 0) && is(R.y, 0, 1, 0) && is(R.z, 0, 0, 1);
}
bool is_zero(const Vec3<>& a) { return a.x == 0 && a.y == 0 && a.z == 0; }
bool is_identity(const SE3<>& C) { return is_identity(C.R) && is_zero(C.r); }

std::string toml_text(const SE3<>& pose) {
  const std::string rotation = is_identity(pose.R) ? "" : ", rotation = " + toml_text(pose.R);
  return "{ position = " + toml_text(pose.r) + rotation + " }";
}
/// The text of a 6×6 matrix: the six numbers of its diagonal if all other entries are 0, else its rows.
std::string toml_text(const SixBySix& A) {
  std::vector<double> diagonal;
  bool is_diagonal = true;
  std::string rows;
  for (std::size_t k = 0; k < 6; ++k) {
    diagonal.push_back(A[k][k]);
    for (std::size_t l = 0; l < 6; ++l) is_diagonal = is_diagonal && (k == l || A[k][l] == 0);
    rows += (k == 0 ? "" : ", ") + toml_text(std::vector<double>(A[k].begin(), A[k].end()));
  }
  return is_diagonal ? toml_text(diagonal) : "[" + rows + "]";
}
template <class T> std::string both(const std::array<T, 2>& x) {
  return "[" + toml_text(x[0]) + ", " + toml_text(x[1]) + "]";
}

class DrawingWriter {
 public:
  explicit DrawingWriter(std::ostream& out) : out_(out) {}

  void write(const Description& d) {
    out_ << "# The mechanism with every joint at zero, in the construction frame. SI units.\n";
    line("format", toml_text("axode drawing 1"));
    line("name", toml_text(d.name));
    line("gravity", toml_text(d.gravity));
    for (const BodyDescription& body : d.bodies) write(body);
    for (const FrameDescription& frame : d.frames) write(frame);
    for (const ShapeDescription& shape : d.shapes) write(shape, "shape");
    for (const SpringDescription& spring : d.springs) write(spring);
    for (const LoopDescription& loop : d.loops) write(loop);
    for (const CouplingDescription& coupling : d.couplings) write(coupling);
    for (const MotionDescription& motion : d.motions) write(motion);
    for (const DriveDescription& drive : d.drives) write(drive);
    if (d.state) write(*d.state);
    if (d.contact) write(*d.contact);
  }

 private:
  void line(std::string_view key, const std::string& value) { out_ << key << " = " << value << '\n'; }

  void write(const BodyDescription& body) {
    out_ << "\n[[body]]\n";
    line("name", toml_text(body.name));
    line("on", toml_text(body.predecessor));
    write(body.geometry);
    write(body.joint, std::holds_alternative<InJointFrames>(body.geometry));
    if (body.inertia) write(*body.inertia, std::holds_alternative<InConstructionFrame>(body.geometry));
    for (const ShapeDescription& shape : body.shapes) write(shape, "body.shape");
  }

  void write(const ShapeDescription& shape, std::string_view key) {
    const ShapeTraits& kind = traits(shape.kind);
    out_ << "\n[[" << key << "]]\n";
    line("kind", toml_text(kind.name));
    if (!shape.name.empty()) line("name", toml_text(shape.name));
    line("role", toml_text(to_string(shape.role)));
    if (!kind.size.empty()) line(kind.size, toml_text(shape.size));
    if (kind.radius) line("radius", toml_text(shape.radius));
    if (kind.length) line("length", toml_text(shape.length));
    if (shape.kind == ShapeKind::mesh) {
      line("file", toml_text(shape.file));
      if (norm(shape.scale - Vec3<>{1, 1, 1}) > 0) line("scale", toml_text(shape.scale));
    }
    write(shape.pose);
    if (const auto& c = shape.color)
      line("color", "[" + toml_text((*c)[0]) + ", " + toml_text((*c)[1]) + ", " + toml_text((*c)[2]) + ", " +
                        toml_text((*c)[3]) + "]");
    if (shape.role == ShapeDescription::Role::collision) write(shape.contact);
  }

  void write(const ContactProperties& contact) {
    if (contact.friction) line("friction", toml_text(*contact.friction));
    if (contact.spin_friction != 0) line("spin_friction", toml_text(contact.spin_friction));
    if (contact.rolling_friction != 0) line("rolling_friction", toml_text(contact.rolling_friction));
    if (contact.restitution != 0) line("restitution", toml_text(contact.restitution));
    if (!contact.stiffness) return;
    line("stiffness", toml_text(*contact.stiffness));
    line("exponent", toml_text(contact.exponent));
    if (contact.damping != 0) line("damping", toml_text(contact.damping));
  }
  void write(const ContactDescription& contact) {
    out_ << "\n[contact]\n";
    line("friction", toml_text(contact.friction));
    line("margin", toml_text(contact.margin));
    line("threshold", toml_text(contact.threshold));
    if (contact.ignored.empty()) return;
    std::string pairs;
    for (const auto& pair : contact.ignored) pairs += (pairs.empty() ? "" : ", ") + both(pair);
    line("ignored", "[" + pairs + "]");
  }

  void write(const SE3<>& pose) {
    line("position", toml_text(pose.r));
    if (!is_identity(pose.R)) line("rotation", toml_text(pose.R));
  }
  void write(const Geometry& geometry) {
    if (const auto* drawn = std::get_if<InConstructionFrame>(&geometry)) {
      if (!is_identity(drawn->A)) line("A", toml_text(drawn->A));
    } else if (const auto* in_body = std::get_if<InBodyFrame>(&geometry)) {
      line("B", toml_text(in_body->B));
    } else {
      const auto& frames = std::get<InJointFrames>(geometry);
      line("S_prev", toml_text(frames.S_prev));
      line("S_self", toml_text(frames.S_self));
    }
  }

  void write(const JointDescription& joint, bool in_joint_frame) {
    const bool has_axis = traits(joint.kind).has("axis"), still = is_at_body_frame(joint.kind);
    const bool said = joint.passive && joint.kind != JointKind::fixed;
    if (still && joint.name.empty() && joint.dof.empty() && !said) {
      line("joint", toml_text(to_string(joint.kind)));
      return;
    }
    if (!joint.name.empty()) line("joint.name", toml_text(joint.name));
    line("joint.kind", toml_text(to_string(joint.kind)));
    const bool along_z = joint.axis.x == 0 && joint.axis.y == 0 && joint.axis.z == 1;
    if (has_axis && !(in_joint_frame && along_z)) line("joint.axis", toml_text(joint.axis));
    if (traits(joint.kind).has("second_axis")) line("joint.second_axis", toml_text(joint.second_axis));
    if (!still && !(in_joint_frame && is_zero(joint.point))) line("joint.point", toml_text(joint.point));
    if (traits(joint.kind).has("pitch")) line("joint.pitch", toml_text(joint.pitch));
    if (said) line("joint.passive", *joint.passive ? "true" : "false");
    if (joint.dof.size() == 1) {
      for (const auto& [key, value] : entries(joint.dof[0])) line("joint." + key, value);
    } else if (!joint.dof.empty()) {
      line("joint.dof", "[");
      for (const Dof& dof : joint.dof) {
        const char* separator = "  { ";
        for (const auto& [key, value] : entries(dof))
          out_ << std::exchange(separator, ", ") << key << " = " << value;
        out_ << (separator[0] == ',' ? " },\n" : "  {},\n");
      }
      out_ << "]\n";
    }
    if (joint.coupling) {
      const Coupling& c = *joint.coupling;
      line("joint.follows", "{ joint = " + toml_text(c.leader) + ", ratio = " + toml_text(c.ratio) +
                                ", offset = " + toml_text(c.offset) + " }");
    }
  }
  static std::string pair(double stiffness, const char* key, double other) {
    return "{ stiffness = " + toml_text(stiffness) +
           (other == 0 ? "" : ", " + std::string(key) + " = " + toml_text(other)) + " }";
  }
  static std::vector<std::pair<std::string, std::string>> entries(const Dof& dof) {
    std::vector<std::pair<std::string, std::string>> all;
    if (std::isfinite(dof.lower) || std::isfinite(dof.upper))
      all.emplace_back("limits", "[" + toml_text(dof.lower) + ", " + toml_text(dof.upper) + "]");
    if (std::isfinite(dof.velocity)) all.emplace_back("velocity", toml_text(dof.velocity));
    if (std::isfinite(dof.effort)) all.emplace_back("effort", toml_text(dof.effort));
    if (dof.damping != 0) all.emplace_back("damping", toml_text(dof.damping));
    if (dof.friction != 0) all.emplace_back("friction", toml_text(dof.friction));
    if (dof.armature != 0) all.emplace_back("armature", toml_text(dof.armature));
    if (dof.gear_loss != 0) all.emplace_back("gear_loss", toml_text(dof.gear_loss));
    if (dof.gear_loss_back) all.emplace_back("gear_loss_back", toml_text(*dof.gear_loss_back));
    if (dof.stiffness != 0 || dof.rest != 0)
      all.emplace_back("spring", pair(dof.stiffness, "rest", dof.rest));
    if (dof.stop_stiffness != 0 || dof.stop_damping != 0)
      all.emplace_back("stop", pair(dof.stop_stiffness, "damping", dof.stop_damping));
    if (dof.hard_stops) all.emplace_back("stop", toml_text("hard"));
    if (dof.restitution != 0) all.emplace_back("restitution", toml_text(dof.restitution));
    return all;
  }

  void write(const MassProperties& given, bool drawn) {
    line("mass", toml_text(given.mass));
    line("com", toml_text(given.com));
    line("inertia", toml_text(given.Theta));
    const GivenIn usual = drawn ? GivenIn::construction_frame : GivenIn::body_frame;
    if (given.in != usual)
      line("inertia_in", toml_text(given.in == GivenIn::body_frame ? "body" : "construction"));
    if (given.about == InertiaAbout::frame_origin) line("inertia_about", toml_text("origin"));
    if (!is_identity(given.axes)) line("inertia_axes", "{ rotation = " + toml_text(given.axes) + " }");
  }

  void write(const FrameDescription& frame) {
    out_ << "\n[[frame]]\n";
    line("name", toml_text(frame.name));
    line("on", toml_text(frame.body));
    if (frame.in == GivenIn::body_frame) line("in", toml_text("body"));
    write(frame.pose);
  }

  void write(const SpringDescription& spring) {
    out_ << "\n[[spring]]\n";
    if (!spring.name.empty()) line("name", toml_text(spring.name));
    if (spring.kind != SpringKind::line) line("kind", toml_text(to_string(spring.kind)));
    if (traits(spring.kind).has("between")) line("between", both(spring.between));
    write_place(spring);
    if (spring.kind == SpringKind::bushing) {
      if (!is_identity(spring.rest_pose)) line("rest_pose", toml_text(spring.rest_pose));
      line("stiffness", toml_text(spring.K));
      if (spring.C != SixBySix{}) line("damping", toml_text(spring.C));
      return;
    }
    if (spring.curve)
      std::visit([&](const auto& curve) { write_curve(curve); }, *spring.curve);
    else if (spring.stiffness != 0 || spring.damping == 0)
      line("stiffness", toml_text(spring.stiffness));
    const bool gas = spring.curve && std::holds_alternative<GasCurve>(*spring.curve);
    if (spring.rest != 0 || gas) line("rest", toml_text(spring.rest));
    if (spring.preload) line("preload", toml_text(*spring.preload));
    if (spring.acts != Acts::both_ways)
      line("one_sided", toml_text(spring.acts == Acts::in_tension ? "tension" : "compression"));
    if (spring.damping != 0) line("damping", toml_text(spring.damping));
  }
  void write_place(const SpringDescription& spring) {
    const bool in_body = spring.in == GivenIn::body_frame;
    const SE3<>&a = spring.frames[0], &b = spring.frames[1];
    switch (spring.kind) {
      case SpringKind::line:
        if (in_body && is_zero(spring.points[0]) && is_zero(spring.points[1])) return;
        line("points", both(spring.points));
        if (in_body) line("in", toml_text("body"));
        return;
      case SpringKind::tendon: {
        std::string points;
        for (const SpringDescription::Point& it : spring.path)
          points += (points.empty() ? "" : ", ") + ("{ on = " + toml_text(it.on)) +
                    ", point = " + toml_text(it.point) + " }";
        line("path", "[" + points + "]");
        if (in_body) line("in", toml_text("body"));
        return;
      }
      case SpringKind::torsion:
      case SpringKind::bushing: {
        const bool drawn = !in_body && is_zero(a.R.x - b.R.x) && is_zero(a.R.y - b.R.y) &&
                           is_zero(a.R.z - b.R.z) && is_zero(a.r - b.r);
        if (drawn && spring.kind == SpringKind::torsion) return line("axis", toml_text(a.R.z));
        if (drawn) return line("pose", toml_text(a));
        line("frames", both(spring.frames));
        if (!in_body) line("in", toml_text("construction"));
        return;
      }
      case SpringKind::joints: return line("terms", by_name(spring.terms));
    }
  }
  void write_curve(const LinearCurve& curve) { line("stiffness", toml_text(curve.stiffness)); }
  void write_curve(const PolynomialCurve& curve) {
    line("law", "{ kind = \"polynomial\", coefficients = " + toml_text(curve.coefficients) + " }");
  }
  void write_curve(const TableCurve& curve) {
    line("law", "{ kind = \"table\", deflections = " + toml_text(curve.deflections) +
                    ", forces = " + toml_text(curve.forces) + " }");
  }
  void write_curve(const GasCurve& gas) {
    line("law", "{ kind = \"gas\", area = " + toml_text(gas.area) +
                    ", pressure = " + toml_text(gas.pressure) + ", volume = " + toml_text(gas.volume) +
                    ", exponent = " + toml_text(gas.exponent) + ", ambient = " + toml_text(gas.ambient) +
                    " }");
  }

  void write(const LoopDescription& loop) {
    const bool named = loop.frames && is_identity((*loop.frames)[0]) && is_identity((*loop.frames)[1]);
    out_ << "\n[[loop]]\n";
    if (!loop.name.empty()) line("name", toml_text(loop.name));
    line(named ? "frames" : "between", both(loop.between));
    line("kind", toml_text(to_string(loop.kind)));
    if (loop.frames && !named) line("frames", both(*loop.frames));
    if (!loop.frames) write_place(loop);
    const LoopTraits& kind = traits(loop.kind);
    if (kind.has("pitch")) line("pitch", toml_text(loop.pitch));
    if (kind.has("length") && loop.length) line("length", toml_text(*loop.length));
    if (kind.has("angle") && loop.angle) line("angle", toml_text(*loop.angle));
    if (kind.has("wheel_axis") && loop.wheel_axis)
      line("wheel_axis", loop.frames ? toml_text("z") : toml_text(*loop.wheel_axis));
    if (kind.has("radius") && loop.radius) line("radius", toml_text(*loop.radius));
    if (kind.has("radii")) line("radii", toml_text(std::vector<double>{loop.radii[0], loop.radii[1]}));
  }
  /// Writes the keys that say where a loop is drawn.
  void write_place(const LoopDescription& loop) {
    const LoopTraits& kind = traits(loop.kind);
    if (kind.has("axis")) line("axis", toml_text(loop.axis));
    if (kind.has("second_axis")) line("second_axis", toml_text(loop.second_axis));
    if (kind.has("points")) line("points", both(loop.points));
    if (kind.has("point") && (kind.located || !is_zero(loop.point))) line("point", toml_text(loop.point));
    if (kind.has("center")) line("center", toml_text(loop.center));
  }

  /// Writes a coupling. Its terms are sorted by name, because they are read in this order.
  void write(const CouplingDescription& coupling) {
    out_ << "\n[[coupling]]\n";
    if (!coupling.name.empty()) line("name", toml_text(coupling.name));
    line("terms", by_name(coupling.terms));
    if (coupling.offset != 0) line("offset", toml_text(coupling.offset));
    if (coupling.play != 0) line("play", toml_text(coupling.play));
    if (coupling.restitution != 0) line("restitution", toml_text(coupling.restitution));
  }

  void write(const MotionDescription& motion) {
    out_ << "\n[[motion]]\n";
    if (!motion.name.empty()) line("name", toml_text(motion.name));
    line("of", toml_text(motion.of));
    for (const auto& [key, value] : entries(motion)) line(key, value);
  }
  /// The keys of a function of time with their values.
  static std::vector<std::pair<std::string, std::string>> entries(const MotionDescription& motion) {
    using Kind = MotionDescription::Kind;
    std::vector<std::pair<std::string, std::string>> all;
    const auto unless_zero = [&](const char* key, double x) {
      if (x != 0) all.emplace_back(key, toml_text(x));
    };
    switch (motion.kind) {
      case Kind::harmonic:
        all.emplace_back("kind", toml_text("harmonic"));
        unless_zero("offset", motion.offset);
        all.emplace_back("amplitude", toml_text(motion.amplitude));
        all.emplace_back("frequency", toml_text(motion.frequency));
        unless_zero("phase", motion.phase);
        break;
      case Kind::ramp:
        all.emplace_back("kind", toml_text("ramp"));
        unless_zero("from", motion.from);
        all.emplace_back("to", toml_text(motion.to));
        unless_zero("start", motion.start);
        all.emplace_back("end", toml_text(motion.end));
        break;
      case Kind::polynomial:
        all.emplace_back("kind", toml_text("polynomial"));
        all.emplace_back("coefficients", toml_text(motion.coefficients));
        break;
      case Kind::samples:
        all.emplace_back("kind", toml_text("samples"));
        all.emplace_back("times", toml_text(motion.times));
        all.emplace_back("values", toml_text(motion.values));
        break;
    }
    return all;
  }

  void write(const DriveDescription& drive) {
    out_ << "\n[[drive]]\n";
    if (!drive.name.empty()) line("name", toml_text(drive.name));
    line("kind", toml_text(to_string(drive.kind)));
    if (drive.line) {
      line("between", both(drive.line->between));
      line("points", both(drive.line->points));
      if (drive.line->in == GivenIn::body_frame) line("in", toml_text("body"));
    } else if (drive.joints.size() == 1 && drive.joints[0].second == 1) {
      line("joint", toml_text(drive.joints[0].first));
    } else {
      line("joints", by_name(drive.joints));
    }
    for (const DriveParameter& parameter : traits(drive.kind).parameters)
      for (const auto& [name, value] : drive.parameters)
        if (name == parameter.name) line(name, toml_text(value));
    if (drive.conditional) line("anti_windup", toml_text("conditional"));
    write(drive.input);
    if (!drive.initial.empty()) line("initial", by_name(drive.initial));
  }
  void write(const DriveInput& input) {
    if (!input.from.empty()) line("input", toml_text(input.from));
    if (input.values.size() == 1) line("input", toml_text(input.values[0]));
    std::vector<std::pair<std::string, std::string>> all;
    if (input.function) all = entries(*input.function);
    if (input.values.size() > 1)
      all = {{"kind", toml_text("steps")},
             {"times", toml_text(input.times)},
             {"values", toml_text(input.values)}};
    std::string joined;
    for (const auto& [key, value] : all) joined += (joined.empty() ? " " : ", ") + key + " = " + value;
    if (!joined.empty()) line("input", "{" + joined + " }");
  }
  /// The text of a table of named numbers. It is sorted by name, because it is read in this order.
  static std::string by_name(std::vector<std::pair<std::string, double>> all) {
    std::ranges::sort(all);
    std::string joined;
    for (const auto& [name, x] : all)
      joined += (joined.empty() ? " " : ", ") + toml_text(name) + " = " + toml_text(x);
    return "{" + joined + " }";
  }

  /// Writes the initial state. Its joints are sorted by name, because they are read in this order.
  void write(const InitialStateDescription& state) {
    out_ << "\n[state]\n";
    if (!state.q.empty()) line("q", by_joint(state.q));
    if (!state.v.empty()) line("v", by_joint(state.v));
  }
  static std::string by_joint(std::vector<std::pair<std::string, std::vector<double>>> all) {
    std::ranges::sort(all);
    std::string joined;
    for (const auto& [joint, numbers] : all)
      joined += (joined.empty() ? " " : ", ") + toml_text(joint) + " = " +
                (numbers.size() == 1 ? toml_text(numbers[0]) : toml_text(numbers));
    return "{" + joined + " }";
  }

  std::ostream& out_;
};

}  // namespace

void write_drawing(const Model& model, std::ostream& out) {
  DrawingWriter(out).write(io::in_construction_frame(model.description()));
}

}  // namespace axode
