#include "apps/study/study_subject.hpp"

namespace axode::command {

template <class Rep, class Frames>
Operations operations(Algorithm algorithm, const Model& model, const State& state) {
  const Tree<double>& tree = model.tree<double>();
  Numbers<Counted> numbers(state, static_cast<std::size_t>(tree->nv));
  Workspace<Counted> workspace(*tree.topology(), footprint_of_study<Counted>(*tree.topology()));
  if constexpr (std::same_as<Rep, Fast>) {
    Counted::count() = {};
    call<Fast>(algorithm, tree, workspace, numbers);
    Counted::count().screws = {};  // the fast kernels do not use the functions that count screw operations
  } else {
    const typename TreeIn<Counted, Frames>::type framed(cast<Counted>(tree));
    Counted::count() = {};
    call<Rep>(algorithm, framed, workspace, numbers);
  }
  return Counted::count();
}

template Operations operations<BodyFixed, JointFrames>(Algorithm, const Model&, const State&);
template Operations operations<Spatial, JointFrames>(Algorithm, const Model&, const State&);
template Operations operations<Hybrid, JointFrames>(Algorithm, const Model&, const State&);
template Operations operations<Mixed, JointFrames>(Algorithm, const Model&, const State&);
template Operations operations<Fast, JointFrames>(Algorithm, const Model&, const State&);
template Operations operations<BodyFixed, UserFrames>(Algorithm, const Model&, const State&);
template Operations operations<Spatial, UserFrames>(Algorithm, const Model&, const State&);
template Operations operations<Hybrid, UserFrames>(Algorithm, const Model&, const State&);
template Operations operations<Mixed, UserFrames>(Algorithm, const Model&, const State&);
template Operations operations<BodyFixed, MassCenterFrames>(Algorithm, const Model&, const State&);
template Operations operations<Spatial, MassCenterFrames>(Algorithm, const Model&, const State&);
template Operations operations<Hybrid, MassCenterFrames>(Algorithm, const Model&, const State&);
template Operations operations<Mixed, MassCenterFrames>(Algorithm, const Model&, const State&);
template Operations operations<BodyFixed, ConstructionFrames>(Algorithm, const Model&, const State&);
template Operations operations<Spatial, ConstructionFrames>(Algorithm, const Model&, const State&);
template Operations operations<Hybrid, ConstructionFrames>(Algorithm, const Model&, const State&);
template Operations operations<Mixed, ConstructionFrames>(Algorithm, const Model&, const State&);

}  // namespace axode::command
