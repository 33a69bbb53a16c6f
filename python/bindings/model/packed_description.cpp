#include <tuple>
#include <type_traits>
#include <variant>

#include "python/bindings/support/description.hpp"

namespace axode::python {
namespace {

// The members of each struct of a description. Packing and unpacking are derived from these lists.
template <class D, class T>
concept Like = std::same_as<std::remove_const_t<D>, T>;

auto fields(Like<Vec3<>> auto& a) { return std::tie(a.x, a.y, a.z); }
auto fields(Like<Sym3<>> auto& A) { return std::tie(A.xx, A.yy, A.zz, A.xy, A.xz, A.yz); }
auto fields(Like<SO3<>> auto& R) { return std::tie(R.x, R.y, R.z); }
auto fields(Like<SE3<>> auto& C) { return std::tie(C.R, C.r); }
auto fields(Like<axode::Source> auto& s) { return std::tie(s.file, s.line); }
auto fields(Like<Fault> auto& f) { return std::tie(f.severity, f.rule, f.element, f.message, f.source); }
auto fields(Like<Dof> auto& d) {
  return std::tie(d.lower, d.upper, d.velocity, d.effort, d.damping, d.friction, d.armature, d.gear_loss,
                  d.gear_loss_back, d.stiffness, d.rest, d.stop_stiffness, d.stop_damping, d.hard_stops,
                  d.restitution);
}
auto fields(Like<Coupling> auto& c) { return std::tie(c.leader, c.ratio, c.offset); }
auto fields(Like<JointDescription> auto& j) {
  return std::tie(j.name, j.kind, j.axis, j.second_axis, j.point, j.pitch, j.dof, j.coupling, j.passive,
                  j.source);
}
auto fields(Like<InConstructionFrame> auto& g) { return std::tie(g.A); }
auto fields(Like<InBodyFrame> auto& g) { return std::tie(g.B); }
auto fields(Like<InJointFrames> auto& g) { return std::tie(g.S_prev, g.S_self); }
auto fields(Like<MassProperties> auto& m) { return std::tie(m.mass, m.com, m.Theta, m.in, m.about, m.axes); }
auto fields(Like<ContactProperties> auto& c) {
  return std::tie(c.friction, c.spin_friction, c.rolling_friction, c.restitution, c.stiffness, c.exponent,
                  c.damping);
}
auto fields(Like<ShapeDescription> auto& s) {
  return std::tie(s.role, s.name, s.kind, s.pose, s.size, s.radius, s.length, s.file, s.scale, s.color,
                  s.contact);
}
auto fields(Like<BodyDescription> auto& b) {
  return std::tie(b.name, b.predecessor, b.joint, b.geometry, b.inertia, b.shapes, b.source);
}
auto fields(Like<FrameDescription> auto& f) { return std::tie(f.name, f.body, f.pose, f.in, f.source); }
auto fields(Like<LinearCurve> auto& c) { return std::tie(c.stiffness); }
auto fields(Like<PolynomialCurve> auto& c) { return std::tie(c.coefficients); }
auto fields(Like<TableCurve> auto& c) { return std::tie(c.deflections, c.forces); }
auto fields(Like<GasCurve> auto& c) { return std::tie(c.area, c.pressure, c.volume, c.exponent, c.ambient); }
auto fields(Like<SpringDescription::Point> auto& p) { return std::tie(p.on, p.point); }
auto fields(Like<SpringDescription> auto& s) {
  return std::tie(s.name, s.kind, s.between, s.points, s.in, s.stiffness, s.rest, s.damping, s.curve, s.acts,
                  s.preload, s.path, s.frames, s.terms, s.rest_pose, s.K, s.C, s.source);
}
auto fields(Like<LoopDescription> auto& l) {
  return std::tie(l.name, l.between, l.kind, l.axis, l.second_axis, l.point, l.pitch, l.points, l.center,
                  l.wheel_axis, l.frames, l.length, l.radius, l.angle, l.radii, l.source);
}
auto fields(Like<CouplingDescription> auto& c) {
  return std::tie(c.name, c.terms, c.offset, c.play, c.restitution, c.source);
}
auto fields(Like<MotionDescription> auto& m) {
  return std::tie(m.name, m.of, m.kind, m.offset, m.amplitude, m.frequency, m.phase, m.from, m.to, m.start,
                  m.end, m.coefficients, m.times, m.values, m.source);
}
auto fields(Like<DriveInput> auto& i) { return std::tie(i.from, i.function, i.times, i.values); }
auto fields(Like<DriveDescription::Line> auto& l) { return std::tie(l.between, l.points, l.in); }
auto fields(Like<DriveDescription> auto& d) {
  return std::tie(d.name, d.kind, d.joints, d.line, d.parameters, d.conditional, d.input, d.initial,
                  d.source);
}
auto fields(Like<InitialStateDescription> auto& s) { return std::tie(s.q, s.v, s.source); }
auto fields(Like<ContactDescription> auto& c) {
  return std::tie(c.friction, c.margin, c.threshold, c.ignored, c.source);
}
auto fields(Like<Description> auto& d) {
  return std::tie(d.name, d.gravity, d.bodies, d.frames, d.shapes, d.springs, d.loops, d.couplings, d.motions,
                  d.drives, d.state, d.contact, d.source, d.warnings);
}

template <class T> struct Packing {
  static nb::object pack(const T& x) {
    return std::apply(
        [](const auto&... each) -> nb::object {
          return nb::make_tuple(Packing<std::remove_cvref_t<decltype(each)>>::pack(each)...);
        },
        fields(x));
  }
  static void unpack(nb::handle from, T& x) {
    std::apply(
        [&](auto&... each) {
          if (nb::len(from) != sizeof...(each))
            throw nb::value_error(
                "state: it was pickled by another version of axode; pickle the model again");
          std::size_t k = 0;
          (Packing<std::remove_cvref_t<decltype(each)>>::unpack(from[k++], each), ...);
        },
        fields(x));
  }
};
template <class T>
  requires std::is_arithmetic_v<T>
struct Packing<T> {
  static nb::object pack(T x) { return nb::cast(x); }
  static void unpack(nb::handle from, T& x) { x = nb::cast<T>(from); }
};
template <class T>
  requires std::is_enum_v<T>
struct Packing<T> {
  static nb::object pack(T x) { return nb::cast(static_cast<int>(x)); }
  static void unpack(nb::handle from, T& x) { x = static_cast<T>(nb::cast<int>(from)); }
};
template <> struct Packing<std::string> {
  static nb::object pack(const std::string& x) { return nb::bytes(x.data(), x.size()); }
  static void unpack(nb::handle from, std::string& x) {
    const nb::bytes text = nb::cast<nb::bytes>(from);
    x.assign(text.c_str(), text.size());
  }
};
template <class E> struct Packing<std::vector<E>> {
  static nb::object pack(const std::vector<E>& all) {
    nb::list list;
    for (const E& x : all) list.append(Packing<E>::pack(x));
    return list;
  }
  static void unpack(nb::handle from, std::vector<E>& all) {
    for (const nb::handle each : from) Packing<E>::unpack(each, all.emplace_back());
  }
};
template <class E, std::size_t N> struct Packing<std::array<E, N>> {
  static nb::object pack(const std::array<E, N>& x) {
    nb::list list;
    for (const E& each : x) list.append(Packing<E>::pack(each));
    return list;
  }
  static void unpack(nb::handle from, std::array<E, N>& x) {
    for (std::size_t k = 0; k < N; ++k) Packing<E>::unpack(from[k], x[k]);
  }
};
template <class A, class B> struct Packing<std::pair<A, B>> {
  static nb::object pack(const std::pair<A, B>& x) {
    return nb::make_tuple(Packing<A>::pack(x.first), Packing<B>::pack(x.second));
  }
  static void unpack(nb::handle from, std::pair<A, B>& x) {
    Packing<A>::unpack(from[0], x.first);
    Packing<B>::unpack(from[1], x.second);
  }
};
template <class E> struct Packing<std::optional<E>> {
  static nb::object pack(const std::optional<E>& x) { return x ? Packing<E>::pack(*x) : nb::none(); }
  static void unpack(nb::handle from, std::optional<E>& x) {
    if (from.is_none()) return;
    x = E{};
    Packing<E>::unpack(from, *x);
  }
};
template <class... E> struct Packing<std::variant<E...>> {
  static nb::object pack(const std::variant<E...>& x) {
    return std::visit(
        [&](const auto& it) -> nb::object {
          return nb::make_tuple(x.index(), Packing<std::remove_cvref_t<decltype(it)>>::pack(it));
        },
        x);
  }
  static void unpack(nb::handle from, std::variant<E...>& x) {
    const auto index = nb::cast<std::size_t>(from[0]);
    std::size_t k = 0;
    const auto unpack_as = [&]<class Each>(Each*) {
      if (k++ == index) Packing<Each>::unpack(from[1], x.template emplace<Each>());
    };
    (unpack_as(static_cast<E*>(nullptr)), ...);
  }
};

}  // namespace

nb::tuple packed(const Description& description) {
  return nb::borrow<nb::tuple>(Packing<Description>::pack(description));
}

Description unpacked(nb::handle tuple) {
  Description description;
  Packing<Description>::unpack(tuple, description);
  return description;
}

}  // namespace axode::python
