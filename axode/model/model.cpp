#include "axode/model/model.hpp"

#include "axode/model/building/nearest_name.hpp"

namespace axode {

namespace {

template <class Named>
int index_of(std::string_view name, std::span<const Named> named, const char* what,
             const std::string& model) {
  for (std::size_t i = 0; i < named.size(); ++i)
    if (named[i].name == name) return static_cast<int>(i);
  std::string parts;  // names of the two joints that a cylindrical or universal joint has become
  for (const Named& n : named)
    if (n.name.starts_with(std::string(name) + '.')) parts += (parts.empty() ? "\"" : ", \"") + n.name + '"';
  throw UnknownName("model \"" + model + "\" has no " + what + " \"" + std::string(name) + "\"" +
                    (parts.empty() ? did_you_mean(name, named, [](const Named& n) { return n.name; })
                                   : "; there are " + parts));
}

}  // namespace

int Model::body_index(std::string_view name) const { return index_of(name, bodies(), "body", this->name()); }
int Model::joint_index(std::string_view name) const {
  return 1 + index_of(name, joints(), "joint", this->name());
}
int Model::frame_index(std::string_view name) const {
  return index_of(name, frames(), "frame", this->name());
}

double Model::total_mass() const {
  double m = 0;
  for (std::size_t i = 1; i < data_->bodies.size(); ++i) m += data_->bodies[i].M.m;
  return m;
}

}  // namespace axode
