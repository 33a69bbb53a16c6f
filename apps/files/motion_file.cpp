#include "apps/files/motion_file.hpp"

#include <fmt/format.h>
#include <zip.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <optional>

#include "apps/files/csv_file.hpp"
#include "apps/files/json_text.hpp"
#include "apps/files/matrix_file.hpp"
#include "apps/files/text_file.hpp"
#include "apps/shell/commands.hpp"
#include "axode/model/configuration.hpp"

namespace axode::command {
namespace {

/// A table of `rows` times `columns` numbers, stored row by row.
struct Rows {
  std::size_t rows = 0, columns = 0;
  std::vector<double> numbers;
};
using Tables = std::map<std::string, Rows, std::less<>>;

[[noreturn]] void refuse(const std::string& sentence) { throw InputError(sentence); }

// ------------------------------------------------------------------------------------------------------ .csv

/// Copies the columns `<what> <name>` of a table, for all names, to out[what]; none if the first is missing.
void gather(const std::vector<std::string>& headings, const std::vector<std::vector<double>>& lines,
            const std::string& what, const std::vector<std::string>& names, const std::string& file,
            Tables& out) {
  std::vector<std::size_t> at;
  for (const std::string& name : names) {
    const std::string heading = name.empty() ? what : what + " " + name;
    const auto found = std::ranges::find(headings, heading);
    if (std::ranges::count(headings, heading) > 1)
      refuse(fmt::format("{}: the column \"{}\" is given more than once", file, heading));
    if (found == headings.end() && at.empty()) return;
    if (found == headings.end()) refuse(fmt::format("{}: there is no column \"{}\"", file, heading));
    at.push_back(static_cast<std::size_t>(found - headings.begin()));
  }
  Rows& rows = out[what];
  rows = {lines.size(), at.size(), {}};
  for (const std::vector<double>& line : lines)
    for (const std::size_t k : at) rows.numbers.push_back(line[k]);
}

/// Collects the loads in a table with the columns `load moment: NAME x` to `load force: NAME z`.
/// out["load_frames"] receives the indices of the frames NAME of the model that have all six columns, and
/// out["loads"] the numbers in these columns.
void gather_loads(const Model& model, const std::vector<std::string>& headings, Tables& out,
                  const std::vector<std::vector<double>>& lines) {
  const std::map<std::string_view, std::size_t> places = [&] {
    std::map<std::string_view, std::size_t> all;
    for (std::size_t k = 0; k < headings.size(); ++k) all.emplace(headings[k], k);
    return all;
  }();
  std::vector<std::size_t> at;
  Rows frames{0, 1, {}};
  for (int f = 0; f < model.n_frames(); ++f) {
    std::vector<std::size_t> of_frame;
    for (const char* what : {"load moment: ", "load force: "})
      for (const char* axis : {" x", " y", " z"})
        if (const auto found = places.find(what + model.frame(f).name + axis); found != places.end())
          of_frame.push_back(found->second);
    if (of_frame.size() != 6) continue;
    at.insert(at.end(), of_frame.begin(), of_frame.end());
    frames.numbers.push_back(f);
    ++frames.rows;
  }
  if (at.empty()) return;
  Rows& loads = out["loads"] = {lines.size(), at.size(), {}};
  for (const std::vector<double>& line : lines)
    for (const std::size_t k : at) loads.numbers.push_back(line[k]);
  out["load_frames"] = std::move(frames);
}

Tables read_csv(const Model& model, const std::string& file) {
  std::vector<std::string> headings;
  std::vector<std::vector<double>> lines;
  for_rows_of_csv(file, [&](std::size_t number, const std::vector<std::string>& words) {
    if (headings.empty()) return void(headings = words);
    if (words.size() != headings.size())
      refuse(fmt::format("{}:{}: there are {} columns; the first line has {}", file, number, words.size(),
                         headings.size()));
    std::vector<double>& numbers = lines.emplace_back();
    for (const std::string& word : words) {
      const std::optional<double> x = number_in(word);
      if (!x) refuse(fmt::format("{}:{}: \"{}\" is not a number", file, number, word.substr(0, 40)));
      numbers.push_back(*x);
    }
  });
  Tables tables;
  gather(headings, lines, "t", {""}, file, tables);
  gather(headings, lines, "q", coordinate_names(model), file, tables);
  for (const char* what : {"v", "a", "tau"})
    gather(headings, lines, what, velocity_names(model), file, tables);
  gather_loads(model, headings, tables, lines);
  return tables;
}

// ------------------------------------------------------------------------------------------------------
// .json

/// The text of an error without its number, for example without "[json.exception.parse_error.101]".
std::string reason_of(const Json::exception& error) {
  const std::string what = error.what();
  return what.substr(what.find("] ") + 2);
}

/// Reads the points of contact in the JSON that `axode simulate` writes.
void read_contacts(const Json& json, const std::string& file, ShownMotion& motion) {
  if (!json.contains("contacts")) return;
  const auto vector = [](const Json& x) {
    const auto [a, b, c] = x.get<std::array<double, 3>>();
    return Vec3<>{a, b, c};
  };
  constexpr std::array branches{LawBranch::open, LawBranch::stick, LawBranch::slide};
  try {
    motion.contact_shapes = json.at("contact_shapes").get<std::vector<std::string>>();
    const auto shape = [&](const Json& name) {
      return static_cast<int>(std::ranges::find(motion.contact_shapes, name.get<std::string>()) -
                              motion.contact_shapes.begin());
    };
    for (const Json& at_once : json.at("contacts")) {
      std::vector<ContactForce>& list = motion.contacts.emplace_back();
      for (const Json& x : at_once) {
        const auto status = x.at("status").get<std::string>();
        const auto branch = std::ranges::find(branches, status, [](LawBranch one) { return to_string(one); });
        if (branch == branches.end()) throw std::invalid_argument("contacts: there is no status " + status);
        list.push_back({.a = shape(x.at("a")),
                        .b = shape(x.at("b")),
                        .point = vector(x.at("point")),
                        .normal = vector(x.at("normal")),
                        .gap = x.at("gap").get<double>(),
                        .force = vector(x.at("force")),
                        .moment = vector(x.at("moment")),
                        .friction = x.at("friction").get<double>(),
                        .branch = *branch});
      }
    }
  } catch (const Json::exception& error) {
    refuse(fmt::format("{}: `contacts`: {}; write the file with `axode simulate --output`", file,
                       reason_of(error)));
  } catch (const std::invalid_argument& wrong) {
    refuse(file + ": " + wrong.what());
  }
}

/// Reads `load_frames` in the JSON that `axode simulate` writes: the names of the frames on which loads act.
/// out["load_frames"] receives the indices of these frames in the model, one in each row.
void read_load_frames(const Model& model, const Json& json, const std::string& file, Tables& out) {
  if (!json.contains("load_frames")) return;
  Rows& frames = out["load_frames"] = {0, 1, {}};
  try {
    for (const Json& name : json["load_frames"]) {
      frames.numbers.push_back(model.frame_index(name.get<std::string>()));
      ++frames.rows;
    }
  } catch (const Json::exception& error) {
    refuse(fmt::format("{}: `load_frames`: {}; write the file with `axode simulate --output`", file,
                       reason_of(error)));
  } catch (const std::invalid_argument& wrong) {
    refuse(fmt::format("{}: `load_frames`: {}", file, wrong.what()));
  }
}

/// Refuses the motion of a mechanism whose coordinates or velocities have other names, or another order.
void check_names(const Model& model, const Json& json, const std::string& file) {
  for (const auto& [key, names] :
       {std::pair{"coordinates", coordinate_names(model)}, {"velocities", velocity_names(model)}}) {
    if (!json.contains(key)) continue;
    const Json& given = json[key];
    if (!given.is_array() || given.size() != names.size())
      refuse(fmt::format("{}: {} must be the names of the {} {} of model \"{}\"", file, key, names.size(),
                         key, model.name()));
    for (std::size_t k = 0; k < names.size(); ++k)
      if (given[k] != names[k])
        refuse(fmt::format("{}: {}[{}] is {}; that of model \"{}\" is \"{}\"", file, key, k, given[k].dump(),
                           model.name(), names[k]));
  }
}

Tables read_json(const Model& model, const std::string& file, ShownMotion& motion) {
  const auto shallow = [&](int depth, Json::parse_event_t, Json&) {
    if (depth > 8) refuse(file + ": it is nested deeper than a motion");
    return true;
  };
  Json json;
  try {
    json = Json::parse(read_text(file), shallow);
  } catch (const Json::exception& error) {
    refuse(file + ": this is not JSON: " + reason_of(error));
  }
  if (!json.is_object()) refuse(file + ": expected an object with t, q and v");
  check_names(model, json, file);
  Tables tables;
  for (const char* name : {"t", "q", "v", "a", "tau", "loads"}) {
    if (!json.contains(name)) continue;
    Rows& rows = tables[name];
    const auto wrong = [&] {
      refuse(fmt::format("{}: {} must have a row for each time and a number in each column", file, name));
    };
    if (!json[name].is_array()) wrong();
    for (const Json& entry : json[name]) {
      const Json row = entry.is_array() ? entry : Json::array({entry});
      if (rows.rows == 0) rows.columns = row.size();
      if (row.size() != rows.columns ||
          !std::ranges::all_of(row, [](const Json& x) { return x.is_number(); }))
        wrong();
      for (const Json& x : row) rows.numbers.push_back(x.get<double>());
      ++rows.rows;
    }
  }
  read_contacts(json, file, motion);
  read_load_frames(model, json, file, tables);
  return tables;
}

// ------------------------------------------------------------------------------------------------------ .npz

/// The header of an .npy file from the value of a key on; empty if the header does not have the key.
std::string_view header_value(std::string_view header, std::string_view key) {
  const std::size_t at = header.find(key);
  return at == std::string_view::npos ? "" : header.substr(at + key.size());
}

Rows read_npy(const std::string& bytes, const std::string& name) {
  const auto byte = [&](std::size_t k) {
    return static_cast<std::size_t>(static_cast<unsigned char>(bytes[k]));
  };
  const auto wrong = [&](const std::string& why) { refuse(name + ": " + why); };
  if (bytes.size() < 12 || !bytes.starts_with("\x93NUMPY")) wrong("it is not an array of numpy");
  const bool first_version = byte(6) == 1;
  const std::size_t begin = first_version ? 10 : 12,
                    length = byte(8) | byte(9) << 8 | (first_version ? 0 : byte(10) << 16 | byte(11) << 24);
  if (length > bytes.size() - begin) wrong("it is cut short");
  const std::string_view header(&bytes[begin], length),
      data(&bytes[begin + length], bytes.size() - begin - length);
  if (!header_value(header, "'descr': ").starts_with("'<f8'") ||
      !header_value(header, "'fortran_order': ").starts_with("False"))
    wrong("it is not an array of float64 in C order; save numpy.ascontiguousarray(x, float)");
  std::vector<std::size_t> shape;
  std::string_view list = header_value(header, "'shape': (");
  list = list.substr(0, list.find(')'));
  while (!list.empty()) {
    std::size_t entry = 0;
    const auto [end, error] = std::from_chars(list.data(), list.data() + list.size(), entry);
    if (error != std::errc()) wrong("its shape cannot be read");
    shape.push_back(entry);
    list.remove_prefix(static_cast<std::size_t>(end - list.data()));
    list.remove_prefix(std::min(list.find_first_not_of(", "), list.size()));
  }
  if (shape.empty() || shape.size() > 2)
    wrong(fmt::format("it has {} axes; a motion has one or two", shape.size()));
  Rows rows{shape[0], shape.size() == 2 ? shape[1] : 1, {}};
  const std::size_t count = data.size() / sizeof(double);
  if (data.size() % sizeof(double) != 0 || rows.rows > count || rows.columns > count + 1 ||
      rows.rows * rows.columns != count)
    wrong(fmt::format("it has {} bytes of numbers, which are not {} x {}", data.size(), rows.rows,
                      rows.columns));
  rows.numbers.resize(count);
  if (count > 0) std::memcpy(rows.numbers.data(), data.data(), data.size());
  return rows;
}

Tables read_npz(const std::string& file) {
  constexpr std::uint64_t most = std::uint64_t{256} << 20;
  int error = 0;
  const std::unique_ptr<zip_t, void (*)(zip_t*)> archive(zip_open(file.c_str(), ZIP_RDONLY, &error),
                                                         zip_discard);
  if (archive == nullptr) refuse(file + ": it cannot be read as an .npz");
  Tables tables;
  for (const char* name : {"t", "q", "v", "a", "tau", "loads", "load_frames"}) {
    const std::string entry = fmt::format("{}.npy", name), where = fmt::format("{}: {}", file, entry);
    zip_stat_t properties;
    zip_stat_init(&properties);
    if (zip_stat(archive.get(), entry.c_str(), 0, &properties) != 0) continue;
    if (properties.size > most) refuse(where + ": it has more than 256 MiB");
    std::string bytes(properties.size, '\0');
    const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> stream(zip_fopen(archive.get(), entry.c_str(), 0),
                                                                   zip_fclose);
    if (stream == nullptr ||
        zip_fread(stream.get(), bytes.data(), bytes.size()) != static_cast<zip_int64_t>(bytes.size()))
      refuse(where + ": it cannot be read");
    tables[name] = read_npy(bytes, where);
  }
  return tables;
}

/// Sets the loads of a motion: the moment and the force on each of the frames, in inertial axes about the
/// origin of the frame.
void set_loads(const std::vector<double>& frames, const std::vector<double>& numbers, ShownMotion& motion) {
  if (numbers.empty()) return;
  const double* W = numbers.data();
  for (std::size_t k = 0; k < motion.t.size(); ++k) {
    std::vector<AppliedWrench<>>& loads = motion.loads.emplace_back();
    for (const double frame : frames) {
      loads.emplace_back(static_cast<int>(frame), Representation::hybrid, Vec3<>{W[0], W[1], W[2]},
                         Vec3<>{W[3], W[4], W[5]});
      W += 6;
    }
  }
}

}  // namespace

ShownMotion read_motion(const Model& model, const std::string& file) {
  Tables tables;
  ShownMotion motion;
  switch (file_format(file, "--motion")) {
    case FileFormat::csv: tables = read_csv(model, file); break;
    case FileFormat::json: tables = read_json(model, file, motion); break;
    case FileFormat::npz: tables = read_npz(file); break;
  }
  const std::size_t N = tables["t"].rows;
  const auto take = [&](const char* name, int width, const char* meaning, bool needed) {
    Rows& rows = tables[name];
    if (rows.rows == 0 && !needed) return std::vector<double>{};
    if (rows.rows == 0 && width > 0)
      refuse(fmt::format("{}: there is no {} in it; a motion of model \"{}\" takes {} x {}{}", file, name,
                         model.name(), N, width, meaning));
    if (rows.rows != N || (N > 0 && rows.columns != static_cast<std::size_t>(width)))
      refuse(fmt::format("{}: {} is {} x {}; model \"{}\" takes {} x {}{}", file, name, rows.rows,
                         rows.columns, model.name(), N, width, meaning));
    return std::move(rows.numbers);
  };
  if (N == 0) refuse(file + ": there are no times in it");
  motion.t = take("t", 1, "", true);
  motion.q = take("q", model.nq(), " (times x nq)", true);
  motion.v = take("v", model.nv(), " (times x nv)", true);
  motion.a = take("a", model.nv(), " (times x nv)", false);
  motion.tau = take("tau", model.nv(), " (times x nv)", false);
  const std::vector<double> frames = std::move(tables["load_frames"].numbers);
  for (const double frame : frames)
    if (!(frame >= 0 && frame < model.n_frames() && frame == std::floor(frame)))
      refuse(fmt::format("{}: load_frames: model \"{}\" has no frame number {}", file, model.name(), frame));
  set_loads(frames,
            take("loads", 6 * static_cast<int>(frames.size()), " (times x 6 per loaded frame)", false),
            motion);
  try {
    check(model, motion);
  } catch (const std::invalid_argument& wrong) {
    refuse(file + ": " + wrong.what());
  }
  return motion;
}

}  // namespace axode::command
