#include "axode/io/sdf/sdf_frames.hpp"

#include <utility>

#include "axode/io/reading.hpp"
#include "axode/model/building/nearest_name.hpp"
#include "axode/model/building/placement.hpp"

namespace axode::io {

int SdfFrames::add(Frame frame, bool* is_new) {
  const int number = size();
  const bool stored = by_path_.emplace(frame.path, number).second;
  if (is_new != nullptr) *is_new = stored;
  first_link_.push_back(0);
  if (frame.kind == Kind::link)
    for (int model = frame.model; model != 0 && first_link_[static_cast<std::size_t>(model)] == 0;
         model = all_[static_cast<std::size_t>(model)].model)
      first_link_[static_cast<std::size_t>(model)] = number;
  all_.push_back(std::move(frame));
  return number;
}

std::string SdfFrames::path(int model, std::string_view name) const {
  return model == 0 ? std::string(name) : (*this)[model].path + "::" + std::string(name);
}

int SdfFrames::find(int model, std::string_view name) const {
  constexpr std::string_view own = "__model__";
  if (name == "world") return 0;
  if (name == own) return model;
  const bool of_nested = name.ends_with("::__model__");
  if (of_nested) name.remove_suffix(own.size() + 2);
  const auto found = by_path_.find(path(model, name));
  return found == by_path_.end() || (of_nested && (*this)[found->second].kind != Kind::model) ? -1
                                                                                              : found->second;
}

std::string SdfFrames::nearest(int model, std::string_view name) {
  if (++suggestions_ > most_suggestions) return "";
  std::vector<std::string> names;
  for (const Frame& frame : all_)
    if (frame.model == model && frame.kind != Kind::world)
      names.push_back(model == 0 ? frame.path : frame.path.substr((*this)[model].path.size() + 2));
  return did_you_mean(name, names, [](const std::string& n) { return n; });
}

std::vector<int> SdfFrames::in_order(int Frame::*next, std::string_view in_a_cycle, const Report& report) {
  enum : char { untouched, open, done };
  std::vector<char> state(all_.size(), untouched);
  std::vector<int> order{0}, chain;
  state[0] = done;
  for (int start = 1; start < size(); ++start) {
    for (int k = start; state[static_cast<std::size_t>(k)] != done; k = (*this)[k].*next) {
      if (state[static_cast<std::size_t>(k)] == open) {
        report(Rule::cycle, (*this)[k], std::string(in_a_cycle));
        (*this)[k].*next = 0;
        break;
      }
      state[static_cast<std::size_t>(k)] = open;
      chain.push_back(k);
    }
    for (; !chain.empty(); chain.pop_back()) {
      state[static_cast<std::size_t>(chain.back())] = done;
      order.push_back(chain.back());
    }
  }
  return order;
}

void SdfFrames::resolve(const Report& report) {
  const auto meant = [&](int k, int model, const std::string& name, const char* what) {
    const int found = find(model, name);
    if (found < 0)
      report(Rule::unknown_frame_body, (*this)[k],
             what + in_quotes(name) + ", which is not described" + nearest(model, name));
    return found < 0 ? model : found;
  };
  for (int k = 1; k < size(); ++k) {
    Frame& it = (*this)[k];
    // A joint moves with its child link, and its pose is relative to that of the child by default.
    const int inside = it.kind == Kind::model ? k : it.model;
    const int carrier = it.attached_to.empty()
                            ? (it.kind == Kind::model ? first_link_[static_cast<std::size_t>(k)] : inside)
                        : it.kind == Kind::joint ? std::max(find(inside, it.attached_to), 0)
                                                 : meant(k, inside, it.attached_to, "is attached to ");
    const bool stands_on_carrier =
        (it.kind == Kind::joint || it.kind == Kind::frame) && !it.attached_to.empty();
    it.moves_with = it.kind == Kind::link ? 0 : carrier;
    it.on = !it.relative_to.empty() ? meant(k, it.model, it.relative_to, "its pose is relative to ")
            : stands_on_carrier     ? carrier
                                    : it.model;
  }
  const std::vector<int> by_pose =
      in_order(&Frame::on, "its pose is relative to itself, by way of others", report);
  for (int k = size() - 1; k > 0; --k) {  // backwards: frames in a model have larger numbers than it
    Frame& model = (*this)[k];
    if (model.placement.empty()) continue;
    SE3<> placement;
    int at = meant(k, k, model.placement, "is placed by its frame ");
    while (at != k && at != 0) {
      placement = (*this)[at].X * placement;
      at = (*this)[at].on;
    }
    if (at == k) {
      model.X = model.X * inverse(placement);
    } else {
      report(
          Rule::wrong_value, model,
          "is placed by its frame " + in_quotes(model.placement) + ", which is not described relative to it");
    }
  }
  for (const int k : by_pose)
    if (k != 0) (*this)[k].pose = (*this)[(*this)[k].on].pose * (*this)[k].X;

  const std::vector<int> by_motion =
      in_order(&Frame::moves_with, "is attached to itself, by way of others", report);
  for (const int k : by_motion) {
    Frame& it = (*this)[k];
    if (k != 0) it.moves_with = it.kind == Kind::link ? k : (*this)[it.moves_with].moves_with;
  }
}

}  // namespace axode::io
