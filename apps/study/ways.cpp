#include "apps/study/ways.hpp"

#include "apps/study/motion_forms.hpp"
#include "apps/study/screws_once.hpp"
#include "apps/study/tangents.hpp"
#include "axode/derivatives/displacement/first_order.hpp"
#include "axode/derivatives/displacement/force_series.hpp"
#include "axode/derivatives/second_order/more_second_order_recursions.hpp"
#include "axode/model/workspace.hpp"

namespace axode::command {
namespace {

template <class T> struct Job {
  const Tree<T>& tree;
  Workspace<T>& workspace;
  const T *q, *rates;  ///< rates are v, a, jerk and snap
  T* out;              ///< 6 numbers for each body, 3 for each velocity, or 3 matrices
  ForceSeries<T>& series;
  TangentDerivatives<T>& tangents;

  Arena arena() const { return workspace.arena(*tree.topology()); }
  const T* v() const { return rates; }
  const T* a() const { return rates + tree->nv; }
  template <class Rates> void put(const Rates* of_body) const {
    T* to = out;
    for (int i = 1; i <= tree->n; ++i)
      for (const Vec3<T>& x : {of_body[i].w, of_body[i].v})
        for (const T& entry : {x.x, x.y, x.z}) *to++ = entry;
  }
};

/// The function that runs one of the compared algorithms, and the size of its result: how many numbers for
/// each body, for each velocity, and for each pair of velocities.
template <class T> struct Kernel {
  void (*run)(const Job<T>&);
  int per_body, per_velocity, per_pair;
};

template <class Rep, class T> void three_times(const Job<T>& job) {
  Arena arena = job.arena();
  InverseDynamicsRecursion<Rep, T> recursion(arena);
  recursion.run(job.tree, job.q, job.v(), job.a(), {});
  recursion.project(job.tree, job.v(), job.a(), false, job.out);
}
template <class Rep, class T> void once(const Job<T>& job) {
  Arena arena = job.arena();
  ScrewsOnce<Rep, T>(arena).run(job.tree, job.q, job.v(), job.a(), job.out);
}
template <class Form, class Rep, class T> void accelerations(const Job<T>& job) {
  Arena arena = job.arena();
  const TreeMotion<Rep, T> motion(arena);
  put_accelerations<Form>(job.tree, motion, job.q, job.v(), job.a());
  job.put(motion.bodies.dV);
}
template <class Rep, class T> void jerks(const Job<T>& job) {
  Arena arena = job.arena();
  Jerks<Rep, T> recursion(arena);
  recursion.run(job.tree, job.q, job.rates);
  job.put(recursion.ddV);
}
template <class Rep, class T> void second_order(const Job<T>& job) {
  Arena arena = job.arena();
  SecondOrderRecursion<Rep, T>(arena).run(job.tree, job.q, job.rates, {}, job.out);
}
template <class T> void series(const Job<T>& job) { job.series.run(job.tree, job.q, job.rates, {}, job.out); }
template <class T> void derivatives(const Job<T>& job) {
  Arena arena = job.arena();
  FirstOrder<T> first_order(arena);
  first_order.run(job.tree, job.q, job.v(), job.a(), {});
  const std::ptrdiff_t size = std::ptrdiff_t{job.tree->nv} * job.tree->nv;
  first_order.write(job.tree, {}, job.out, job.out + size, job.out + 2 * size);
}

template <class Rep, class T> void tangents(const Job<T>& job) {
  job.tangents.template run<Rep>(job.q, job.v(), job.a(), job.out);
}

template <class T> std::vector<std::pair<Way, Kernel<T>>> kernels() {
  using enum Representation;
  std::vector<std::pair<Way, Kernel<T>>> all;
  const auto add = [&](Way way, void (*run)(const Job<T>&), Kernel<T> size) {
    size.run = run;
    all.push_back({way, size});
  };
  const auto in_all = [&](std::string_view name, auto run) {
    for (const auto& [word, representation] : representations)
      with_representation(representation, [&, representation = representation](auto rep) {
        add({"inverse_dynamics", name, representation}, run(rep), {.per_velocity = 1});
      });
  };
  in_all("three times", []<class Rep>(Rep) { return three_times<Rep, T>; });
  in_all("once", []<class Rep>(Rep) { return once<Rep, T>; });
  const Kernel<T> twists{.run = nullptr, .per_body = 6}, forces{.run = nullptr, .per_velocity = 3};
  add({"accelerations", "arecVbi", body}, accelerations<FormA, BodyFixed, T>, twists);
  add({"accelerations", "brecVbi", body}, accelerations<FormB, BodyFixed, T>, twists);
  add({"accelerations", "crecVbi", body}, accelerations<FormC, BodyFixed, T>, twists);
  add({"accelerations", "arecVbi, sparse", body}, accelerations<SparseFormA, BodyFixed, T>, twists);
  add({"accelerations", "crecVbi, sparse", body}, accelerations<SparseFormC, BodyFixed, T>, twists);
  add({"accelerations", "recVhdot1", hybrid}, accelerations<Form1, Hybrid, T>, twists);
  add({"accelerations", "recVhdot2", hybrid}, accelerations<Form2, Hybrid, T>, twists);
  add({"accelerations", "recVhdot3", hybrid}, accelerations<Form3, Hybrid, T>, twists);
  add({"jerks", "recursion", body}, jerks<BodyFixed, T>, twists);
  add({"jerks", "recursion", spatial}, jerks<Spatial, T>, twists);
  add({"jerks", "recursion", hybrid}, jerks<Hybrid, T>, twists);
  add({"jerks", "recursion", mixed}, jerks<Mixed, T>, twists);
  add({"second_order_inverse_dynamics", "recursion", body}, second_order<BodyFixed, T>, forces);
  add({"second_order_inverse_dynamics", "recursion", spatial}, second_order<Spatial, T>, forces);
  add({"second_order_inverse_dynamics", "series", spatial}, series<T>, forces);
  add({"second_order_inverse_dynamics", "recursion", hybrid}, second_order<Hybrid, T>, forces);
  add({"second_order_inverse_dynamics", "recursion", mixed}, second_order<Mixed, T>, forces);
  const Kernel<T> matrices{.run = nullptr, .per_pair = 3};
  add({"inverse_dynamics_derivatives", "displacements", spatial}, derivatives<T>, matrices);
  add({"inverse_dynamics_derivatives", "tangents", body}, tangents<BodyFixed, T>, matrices);
  add({"inverse_dynamics_derivatives", "tangents", spatial}, tangents<Spatial, T>, matrices);
  add({"inverse_dynamics_derivatives", "tangents", hybrid}, tangents<Hybrid, T>, matrices);
  add({"inverse_dynamics_derivatives", "tangents", mixed}, tangents<Mixed, T>, matrices);
  return all;
}

template <class T> class SubjectIn : public WaySubject {
 public:
  SubjectIn(std::size_t number, const Model& model, const Tree<T>& tree, const State& state)
      : kernel_(kernels<T>()[number].second),
        tree_(tree),
        workspace_(*tree.topology(), footprint_of(*tree.topology())),
        q_(state.q.begin(), state.q.end()),
        rates_(state.v.begin(), state.v.end()),
        out_(static_cast<std::size_t>(kernel_.per_body * tree->n + kernel_.per_velocity * tree->nv +
                                      kernel_.per_pair * tree->nv * tree->nv)),
        series_(tree_, 2),
        tangents_(model, tree_, state.q) {
    for (const auto& row : {state.a, state.v, state.a}) rates_.insert(rates_.end(), row.begin(), row.end());
  }
  void run(int calls) override {
    const Job<T> job{tree_, workspace_, q_.data(), rates_.data(), out_.data(), series_, tangents_};
    for (int k = 0; k < calls; ++k) kernel_.run(job);
  }
  std::vector<double> results() override {
    run(1);
    std::vector<double> out;
    for (const T& x : out_) out.push_back(static_cast<double>(x));
    return out;
  }

 private:
  static std::size_t footprint_of(const Topology& t) {
    const auto of = [&]<class Rep>(Rep) {
      return footprint<InverseDynamicsRecursion<Rep, T>, ScrewsOnce<Rep, T>, TreeMotion<Rep, T>,
                       Jerks<Rep, T>, SecondOrderRecursion<Rep, T>>(t);
    };
    return std::max({of(BodyFixed{}), of(Spatial{}), of(Hybrid{}), of(Mixed{}), footprint<FirstOrder<T>>(t)});
  }

  Kernel<T> kernel_;
  Tree<T> tree_;
  Workspace<T> workspace_;
  std::vector<T> q_, rates_, out_;
  ForceSeries<T> series_;
  TangentDerivatives<T> tangents_;
};

std::size_t number_of(const Way& way) {
  const auto at = std::ranges::find_if(ways(), [&](const Way& other) {
    return other.algorithm == way.algorithm && other.name == way.name &&
           other.representation == way.representation;
  });
  return static_cast<std::size_t>(at - ways().begin());
}

}  // namespace

const std::vector<Way>& ways() {
  static const std::vector<Way> all = [] {
    std::vector<Way> out;
    for (const auto& [way, kernel] : kernels<double>()) out.push_back(way);
    return out;
  }();
  return all;
}

std::unique_ptr<WaySubject> make_subject(const Way& way, const Model& model, const State& state) {
  return std::make_unique<SubjectIn<double>>(number_of(way), model, model.tree<double>(), state);
}

Operations operations(const Way& way, const Model& model, const State& state) {
  SubjectIn<Counted> subject(number_of(way), model, cast<Counted>(model.tree<double>()), state);
  Counted::count() = {};
  subject.run(1);
  return Counted::count();
}

}  // namespace axode::command
