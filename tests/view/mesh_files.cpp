#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "tests/support/run_program.hpp"
#include "tests/view/scene_json.hpp"

/// Mesh files are searched where their names point to, and shown only if a reader can rely on them.
namespace axode::test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

template <class T> std::string bytes_of(const T& x) {
  std::string out(sizeof(T), '\0');
  std::memcpy(out.data(), &x, sizeof(T));
  return out;
}

std::string binary_stl(std::uint32_t told, const std::vector<std::array<float, 9>>& triangles) {
  std::string out(80, ' ');
  out += bytes_of(told);
  for (const auto& triangle : triangles) {
    out += std::string(12, '\0');
    for (const float x : triangle) out += bytes_of(x);
    out += std::string(2, '\0');
  }
  return out;
}
const std::array<float, 9> corner{0, 0, 0, 1, 0, 0, 0, 1, 0};

std::string glb(const std::string& json, const std::string& buffer) {
  const auto size = [](std::size_t n) { return bytes_of(static_cast<std::uint32_t>(n)); };
  std::string text = json;
  text.append((4 - text.size() % 4) % 4, ' ');
  return "glTF" + size(2) + size(12 + 8 + text.size() + 8 + buffer.size()) + size(text.size()) + "JSON" +
         text + size(buffer.size()) + std::string("BIN\0", 4) + buffer;
}
std::string gltf_json(int count, const std::string& more = "") {
  return R"({"asset": {"version": "2.0"}, "buffers": [{"byteLength": 36}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
             "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": )" +
         std::to_string(count) + R"(}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}])" +
         more + "}";
}
std::string nine_floats(float last) {
  std::string out;
  for (int k = 0; k < 8; ++k) out += bytes_of(static_cast<float>(k));
  return out + bytes_of(last);
}

const std::string text_stl =
    "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1e0 "
    "-0\nendloop\nendfacet\nendsolid a\n";
const std::string obj = "# a corner\nv 0 0 0\nv 1 0 0\nv +0 1e-3 0\nvn 0 0 1\nf 1//1 2//1 -1//1\n";
const std::string dae =
    "<?xml version=\"1.0\"?><COLLADA><library_geometries><geometry id=\"g\"><mesh><source id=\"s\">"
    "<float_array id=\"f\" count=\"3\">0 1 "
    "2</float_array></source></mesh></geometry></library_geometries></COLLADA>";

TEST(MeshFiles, OfEveryFormatAreRead) {
  const TemporaryFolder folder;
  for (const auto& [name, format, text] :
       std::vector<std::array<std::string, 3>>{{"a.stl", "stl", binary_stl(1, {corner})},
                                               {"b.STL", "stl", text_stl},
                                               {"c.obj", "obj", obj},
                                               {"d.dae", "dae", dae},
                                               {"e.glb", "glb", glb(gltf_json(3), nine_floats(0))},
                                               {"f.gltf", "gltf", gltf_json(3)}}) {
    const MeshFile mesh = read_mesh(folder.write(name, text));
    EXPECT_EQ(mesh.error, "") << name;
    EXPECT_EQ(mesh.format, format);
    EXPECT_EQ(mesh.bytes, text) << name;
  }
}

TEST(MeshFiles, ABinaryOneMayBeginLikeText) {
  std::string bytes = binary_stl(2, {corner, corner});
  bytes.replace(0, 12, "solid robot\0", 12);
  const TemporaryFolder folder;
  EXPECT_EQ(read_mesh(folder.write("a.stl", bytes)).error, "");
}

TEST(MeshFiles, ThatAReaderCannotRelyOnAreRefusedInOneSentence) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::array<float, 9> broken = corner;
  broken[4] = nan;
  std::string deep(200'000, '[');
  std::string nested = "<COLLADA>";
  for (int k = 0; k < 100'000; ++k) nested += "<node>";
  const std::vector<std::array<std::string, 3>> bad{
      {"a.stl", "", "it has 0 bytes, too few for an STL"},
      {"a.stl", binary_stl(0, {}), "it has no triangles"},
      {"a.stl", binary_stl(4'000'000'000, {corner}),
       "it says that it has 4000000000 triangles, which take 200000000084 bytes, and has 134"},
      {"a.stl", binary_stl(1, {corner}).substr(0, 130), "it says that it has 1 triangles"},
      {"a.stl", binary_stl(2, {corner, broken}), "a vertex of triangle 1 is not finite"},
      {"a.stl", "solid a\nendsolid a\n", "it has no triangles"},
      {"a.stl", text_stl.substr(0, text_stl.find("1e0")), "one of its coordinates is "},
      {"a.stl", "solid\nvertex 1 2 nan\n", "one of its coordinates is \"nan\", no finite number"},
      {"a.stl", "solid\nvertex 1 2 1e99\n", "one of its coordinates is \"1e99\", no finite number"},
      {"a.stl", "solid\nvertex 1 2 3\nvertex 1 2 3\n", "it has 2 vertices; a triangle takes three"},
      {"a.obj", "", "it has no faces"},
      {"a.obj", "v 1 2\nf 1 1 1\n", "one of its coordinates is missing, no finite number"},
      {"a.obj", "v 1 2 x\n", "one of its coordinates is \"x\", no finite number"},
      {"a.obj", "v 0 0 0\nf 1 1 2\n", "face 1 has the corner \"2\", and there are 1 vertices before it"},
      {"a.obj", "v 0 0 0\nf 1 1 0\n", "face 1 has the corner \"0\""},
      {"a.obj", "v 0 0 0\nf 1 1 9223372036854775808\n", "face 1 has the corner \"9223372036854775808\""},
      {"a.obj", "v 0 0 0\nf 1 1 -9223372036854775808\n", "face 1 has the corner"},
      {"a.obj", "v 0 0 0\nf 1 1\n", "face 1 has fewer than three corners"},
      {"a.dae", "<COLLADA>", "it is no well-formed XML, see its line 1"},
      {"a.dae", "<robot/>", "it is XML, and no COLLADA"},
      {"a.dae", "<COLLADA/>", "it has no geometry"},
      {"a.dae", nested, "it is no well-formed XML"},
      {"a.dae", std::string(dae).replace(dae.find("0 1 2"), 5, "0 1 inf"),
       "one of its coordinates is \"inf\""},
      {"a.dae", std::string(dae).replace(dae.find("0 1 2"), 5, "0 1"),
       "one of its arrays says that it has 3 numbers"},
      {"a.glb", "glTF", "it is no binary glTF"},
      {"a.glb", glb(gltf_json(3), nine_floats(0)) + "x", "it says that it has"},
      {"a.glb", glb(gltf_json(3), nine_floats(nan)), "entry 2 of an accessor is not finite"},
      {"a.glb", glb(gltf_json(4), nine_floats(0)), "an accessor has 4 entries, more than its buffer holds"},
      {"a.glb", glb(gltf_json(2'000'000'000), nine_floats(0)), "an accessor has 2000000000 entries"},
      {"a.glb", glb(gltf_json(-1), nine_floats(0)), "an accessor has 18446744073709551615 entries"},
      {"a.glb", glb("{", ""), "its JSON chunk is not JSON"},
      {"a.glb", glb("{}", ""), "its JSON is not that of a glTF"},
      {"a.gltf", deep, "its JSON chunk is not JSON"},
      {"a.gltf", "[]", "its JSON is not that of a glTF"},
      {"a.gltf", gltf_json(3, R"(, "images": [{"uri": "../skin.png"}])"),
       "it needs another file, \"../skin.png\"; a .glb has everything in one"},
      {"a.gltf", gltf_json(3, R"(, "extensionsRequired": ["KHR_draco_mesh_compression"])"),
       "it is compressed by KHR_draco_mesh_compression, which the page cannot read"},
      {"a.ply", "ply", "its ending \".ply\" is none of .stl, .obj, .dae, .glb, .gltf"},
  };
  const TemporaryFolder folder;
  for (const auto& [name, text, sentence] : bad) {
    const MeshFile mesh = read_mesh(folder.write(name, text));
    EXPECT_THAT(mesh.error, StartsWith(sentence)) << name << ": " << text.substr(0, 60);
    EXPECT_EQ(mesh.bytes, "");
    EXPECT_EQ(mesh.error.find('\n'), std::string::npos);
  }
  const std::string large = folder.write("large.stl", "");
  std::filesystem::resize_file(large, largest_mesh + (1 << 20));
  EXPECT_EQ(read_mesh(large).error, "it has 65 MiB; a mesh may have 64");
  EXPECT_THAT(read_mesh(folder.file("none.stl")).error, StartsWith("it cannot be read"));
}

TEST(MeshFiles, CutShortAnywhereAreRefusedOrWholeWithoutTheRest) {
  const TemporaryFolder folder;
  const std::string scene = glb(gltf_json(3), nine_floats(0));
  for (std::size_t n = 0; n < scene.size(); ++n)
    EXPECT_NE(read_mesh(folder.write("a.glb", scene.substr(0, n))).error, "") << n;
  const std::string triangles = binary_stl(3, {corner, corner, corner});
  for (std::size_t n = 0; n < triangles.size(); ++n)
    EXPECT_NE(read_mesh(folder.write("a.stl", triangles.substr(0, n))).error, "") << n;
}

/// Gives an environment variable another value until the end of the scope.
class Setting {
 public:
  Setting(const char* name, const std::string& value) : name_(name) {
    if (const char* now = std::getenv(name)) before_ = now;
    setenv(name, value.c_str(), 1);
  }
  ~Setting() { before_ ? setenv(name_, before_->c_str(), 1) : unsetenv(name_); }
  Setting(const Setting&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

class FindMesh : public testing::Test {
 protected:
  FindMesh() {
    for (const char* at : {"arm/meshes", "arm/urdf", "ws/share/gripper", "src/my_folder", "elsewhere/arm"})
      std::filesystem::create_directories(folder_.path() / at);
    folder_.write("arm/meshes/a link.stl", "");
    folder_.write("arm/urdf/beside.stl", "");
    folder_.write("ws/share/gripper/jaw.stl", "");
    folder_.write("src/my_folder/package.xml", "<package><name>tool</name></package>");
    folder_.write("src/my_folder/tip.stl", "");
    folder_.write("elsewhere/arm/only_here.stl", "");
    folder_.write("secret", "");
  }
  /// The path of the mesh that was found, relative to the folder, or the reason why none was found.
  std::string find(const std::string& name, const std::string& referenced_from = "arm/urdf/arm.urdf") const {
    const FoundMesh found = find_mesh(name, {folder_.file(referenced_from), 1});
    if (found.error.empty())
      return std::filesystem::canonical(found.file)
          .lexically_relative(std::filesystem::canonical(folder_.path()))
          .string();
    EXPECT_TRUE(found.file.empty());
    return found.error;
  }

  TemporaryFolder folder_;
  Setting no_ros_{"ROS_PACKAGE_PATH", ""}, no_ament_{"AMENT_PREFIX_PATH", ""},
      no_sim_{"GZ_SIM_RESOURCE_PATH", ""}, no_classic_{"GAZEBO_MODEL_PATH", ""};
};

TEST_F(FindMesh, BesideTheFileAndByAbsolutePaths) {
  EXPECT_EQ(find("beside.stl"), "arm/urdf/beside.stl");
  EXPECT_EQ(find("../meshes/a link.stl"), "arm/meshes/a link.stl");
  EXPECT_EQ(find(folder_.file("arm/urdf/beside.stl")), "arm/urdf/beside.stl");
  EXPECT_EQ(find("file://" + folder_.file("arm/meshes/a%20link.stl")), "arm/meshes/a link.stl");
  EXPECT_EQ(find("file://localhost" + folder_.file("arm/urdf/beside.stl")), "arm/urdf/beside.stl");
  EXPECT_THAT(find("none.stl"), StartsWith("there is no file \""));
  EXPECT_THAT(find("../meshes"), StartsWith("there is no file \""));
  EXPECT_EQ(find(""), "its file has no name");
}

TEST_F(FindMesh, InThePackageThatHoldsTheFile) {
  EXPECT_EQ(find("package://arm/meshes/a link.stl"), "arm/meshes/a link.stl");
  EXPECT_EQ(find("package://arm/meshes/a link.stl", "arm/urdf/deeper/than/that.urdf"),
            "arm/meshes/a link.stl");
  EXPECT_EQ(find("package://tool/tip.stl", "src/my_folder/tool.urdf"), "src/my_folder/tip.stl");
  EXPECT_EQ(find("package://arm/urdf/beside.stl", "other.urdf"), "arm/urdf/beside.stl");
}

TEST_F(FindMesh, InModelsAsGazeboSearchesThem) {
  EXPECT_EQ(find("model://arm/meshes/a link.stl"), "arm/meshes/a link.stl");
  EXPECT_THAT(
      find("model://gripper/no.stl"),
      StartsWith("there is no model \"gripper\" in GZ_SIM_RESOURCE_PATH, in GAZEBO_MODEL_PATH and in \""));
  const Setting sim("GZ_SIM_RESOURCE_PATH", folder_.file("elsewhere")),
      classic("GAZEBO_MODEL_PATH", folder_.file("ws/share"));
  EXPECT_EQ(find("model://arm/only_here.stl"), "elsewhere/arm/only_here.stl");
  EXPECT_EQ(find("model://gripper/jaw.stl"), "ws/share/gripper/jaw.stl");
  folder_.write("src/my_folder/model.config", "<model><name>chisel</name></model>");
  EXPECT_EQ(find("model://chisel/tip.stl", "src/my_folder/chisel.sdf"), "src/my_folder/tip.stl");
  EXPECT_EQ(find("model://arm/../secret"), "it is not a path within a model");
}

TEST_F(FindMesh, InThePackagesOfTheEnvironment) {
  EXPECT_THAT(
      find("package://gripper/jaw.stl"),
      StartsWith("there is no package \"gripper\" in ROS_PACKAGE_PATH, in AMENT_PREFIX_PATH and in \""));
  EXPECT_THAT(find_mesh("package://gripper/jaw.stl", {"arm.urdf", 1}).error,
              HasSubstr("and in \".\" and the folders that hold it"))
      << "told in a file of the folder where one is";
  {
    const Setting ament("AMENT_PREFIX_PATH", "/nowhere::" + folder_.file("ws"));
    EXPECT_EQ(find("package://gripper/jaw.stl"), "ws/share/gripper/jaw.stl");
  }
  const Setting ros("ROS_PACKAGE_PATH", folder_.file("elsewhere") + ":" + folder_.file("src/my_folder"));
  EXPECT_EQ(find("package://arm/only_here.stl"), "elsewhere/arm/only_here.stl");
  EXPECT_EQ(find("package://arm/urdf/beside.stl"),
            "arm/urdf/beside.stl");  // the first package of that name does not have this file
  EXPECT_EQ(find("package://tool/tip.stl"), "src/my_folder/tip.stl");
  EXPECT_THAT(find("package://arm/no.stl"), HasSubstr("elsewhere/arm\", which has no file \"no.stl\""));
}

TEST_F(FindMesh, NeverOutsideAPackageNorElsewhere) {
  for (const char* name : {"package://arm/../secret", "package://arm/meshes/../../secret",
                           "package://../secret", "package://..//secret", "package:///secret",
                           "package://arm", "package://arm/", "package://./secret", "package://"})
    EXPECT_EQ(find(name), "it is not a path within a package") << name;
  EXPECT_EQ(find("package://arm//secret"), "it is not a path within a package");
  EXPECT_EQ(find("file://host/secret"), "it is on another machine");
  EXPECT_EQ(find("http://host/a.stl"), "\"http://\" is none of package://, model://, file://");
  EXPECT_EQ(find(std::string("beside.stl\0.png", 15)), "there is a zero byte in its name");
}

TEST(Meshes, AreInTheSceneOnceAndMissingOnesAreWarnings) {
  const TemporaryFolder folder;
  folder.write("good.stl", binary_stl(1, {corner}));
  folder.write("bad.stl", "no mesh");
  std::string links;
  for (const char* file : {"good.stl", "./good.stl", "good.stl", "bad.stl", "bad.stl",
                           "package://robot/a.dae", "package://robot/b.dae"})
    links += std::string("<visual><geometry><mesh filename=\"") + file +
             "\" scale=\"1 2 3\"/></geometry></visual>";
  const std::string file =
      folder.write("robot.urdf", "<robot name=\"r\"><link name=\"base\">" + links + "</link></robot>");
  const Model model = load(file);
  std::ostringstream out;
  const SceneContents contents = write_scene(model, neutral(model), out);
  const Json scene = Json::parse(out.str());
  ASSERT_EQ(scene["meshes"].size(), 1U);
  EXPECT_EQ(scene["meshes"][0]["file"], "good.stl");
  EXPECT_EQ(scene["meshes"][0]["format"], "stl");
  EXPECT_EQ(scene["shapes"].size(), 3U);
  for (const Json& shape : scene["shapes"]) {
    EXPECT_EQ(shape["mesh"], 0);
    EXPECT_EQ(shape["scale"], Json({1.0, 2.0, 3.0}));
  }
  ASSERT_EQ(contents.meshes.size(), 1U);
  EXPECT_EQ(contents.meshes[0].bytes, 134U);
  ASSERT_EQ(contents.warnings.size(), 2U);
  EXPECT_EQ(
      contents.warnings[0],
      file + ":1: warning: body \"base\": mesh \"bad.stl\" is not shown: it has 7 bytes, too few for an STL");
  EXPECT_THAT(
      contents.warnings[1],
      testing::AllOf(HasSubstr("mesh \"package://robot/a.dae\" is not shown: there is no package \"robot\""),
                     testing::EndsWith(" (2 meshes, the first here)")));
  EXPECT_EQ(scene["warnings"], Json(contents.warnings));
}

TEST(Meshes, AreWrittenInBase64) {
  const TemporaryFolder folder;
  for (std::size_t more = 0; more < 3; ++more) {
    std::string bytes = obj + std::string(more, '\n');
    const std::string name = folder.write("a.obj", bytes);
    const Model model =
        ModelBuilder(Description{.shapes = {{.kind = ShapeKind::mesh, .file = name}}}).build();
    const std::string text = scene_of(model, {})["meshes"][0]["data"];
    const Outcome decoded = run({"base64", "-d"}, text);
    EXPECT_EQ(decoded.out, bytes);
    EXPECT_EQ(decoded.code, 0);
  }
}

}  // namespace
}  // namespace axode::test
