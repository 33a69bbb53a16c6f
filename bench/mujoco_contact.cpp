// MuJoCo's constraint solver and steps with elliptic cones, for the standing robot of contact.cpp. Its
// contacts are soft; a cold solver begins without accelerations, and a warm one with those of the state.
#include <mujoco/mujoco.h>

#include <memory>
#include <sstream>

#include "bench/contact_subjects.hpp"

namespace {

using namespace axode;
using namespace axode::bench;

/// The robot at rest on its feet, with springs and dampers in its joints.
struct PeerRobot {
  std::shared_ptr<mjModel> model;
  std::shared_ptr<mjData> data;

  explicit PeerRobot(const Standing& robot) {
    std::ostringstream text;
    static_cast<void>(write_mjcf(robot.model, text));
    char error[1000] = "";
    const std::unique_ptr<mjSpec, void (*)(mjSpec*)> spec(
        mj_parseXMLString(text.str().c_str(), nullptr, error, sizeof error), mj_deleteSpec);
    if (!spec) throw std::runtime_error(error);
    model = {mj_compile(spec.get(), nullptr), mj_deleteModel};
    if (!model) throw std::runtime_error(mjs_getError(spec.get()));
    model->opt.cone = mjCONE_ELLIPTIC;
    model->opt.timestep = Standing::h;
    data = {mj_makeData(model.get()), mj_deleteData};
    data->qpos[2] = robot.q[6];
    for (int j = 1; j < model->njnt; ++j) {
      const int i = robot.model.joint_index(mj_id2name(model.get(), mjOBJ_JOINT, j));
      const int at = model->jnt_qposadr[j];
      data->qpos[at] = model->qpos_spring[at] = robot.q[static_cast<std::size_t>(robot.model.joint(i).iq)];
      model->jnt_stiffness[j] = Standing::stiffness;
      model->dof_damping[model->jnt_dofadr[j]] = Standing::damping;
    }
    for (int k = 0; k < 500; ++k) mj_step(model.get(), data.get());
  }
};

const bool registered = [] {
  for (const Standing& robot : standing_robots()) {
    for (const bool cold : {true, false})
      benchmark::RegisterBenchmark(cold ? "contact_cold/solo12/mujoco" : "contact_warm/solo12/mujoco",
                                   [robot, cold](benchmark::State& state) {
                                     const PeerRobot peer(robot);
                                     mj_forward(peer.model.get(), peer.data.get());
                                     repeat(state, peer.data->qacc, [&] {
                                       if (cold)
                                         mju_zero(peer.data->qacc_warmstart,
                                                  static_cast<int>(peer.model->nv));
                                       mj_fwdConstraint(peer.model.get(), peer.data.get());
                                     });
                                   });
    benchmark::RegisterBenchmark("contact_step/solo12/mujoco", [robot](benchmark::State& state) {
      const PeerRobot peer(robot);
      repeat(state, peer.data->qpos, [&] { mj_step(peer.model.get(), peer.data.get()); });
    });
  }
  return true;
}();

}  // namespace
