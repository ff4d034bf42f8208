// SPDX-License-Identifier: MIT
#include "settings.h"

#include <array>
#include <limits>
#include <memory>
#include <string_view>
#include <vector>

#include "world/contact_model_names.h"

namespace poise::python {
namespace {

constexpr std::array<std::string_view, 3> kExecutors{"tbb", "threads", "serial"};
constexpr std::array<std::string_view, 3> kContacts{"paper", "wrench", "fitted"};
constexpr std::array<std::string_view, 3> kWaits{"never", "near_rest", "any"};

void set_executor(SettingsValue& value, const std::string& name) {
  const std::size_t which = index_of("executor", name, kExecutors);
#ifndef POISE_PYTHON_HAVE_TBB
  if (which == 0) raise(bad_input("executor = tbb, this build has no oneTBB"));
#endif
  value.settings.executor = static_cast<ExecutorKind>(which);
}

template <class T>
void bind_count(py::class_<SettingsValue>& bound, const char* name, T WorldSettings::*member, const char* doc) {
  bound.def_property(
      name, [member](const SettingsValue& s) { return s.settings.*member; },
      [member, name](SettingsValue& s, const py::object& given) {
        s.settings.*member =
            static_cast<T>(whole_of(name, given, static_cast<std::uint64_t>(std::numeric_limits<T>::max())));
      },
      doc);
}

void bind_threads(py::class_<SettingsValue>& bound) {
  bound
      .def_property(
          "executor",
          [](const SettingsValue& s) { return std::string(kExecutors[static_cast<std::size_t>(s.settings.executor)]); },
          &set_executor, "'tbb' (oneTBB's threads), 'threads' (the World's own) or 'serial'. Fixed at creation.")
      .def_property(
          "spin_s", [](const SettingsValue& s) { return seconds_of(s.settings.spin); },
          [](SettingsValue& s, double seconds) { s.settings.spin = nanoseconds_of("spin_s", seconds); },
          "For how long a thread without work polls before it sleeps, seconds in [0, 0.01].")
      .def_property(
          "processors",
          [](const SettingsValue& s) {
            py::list listed;
            for (const int processor : s.settings.processors) listed.append(processor);
            return listed;
          },
          [](SettingsValue& s, const py::iterable& processors) {
            std::vector<int> listed;
            for (const py::handle& one : processors)
              listed.push_back(static_cast<int>(whole_of("processors", one, 1'000'000)));
            s.settings.processors = std::move(listed);
          },
          "Thread w >= 1 runs only on processors[w mod size]; not with 'tbb'. Empty: anywhere.");
  bind_count(bound, "threads", &WorldSettings::threads,
             "Threads of a step, the calling one included, at most 256; 0: as many as the machine has.");
  bind_count(bound, "realtime_priority", &WorldSettings::realtime_priority,
             "Of the World's threads under SCHED_FIFO, 1 to 99; 0: none. Not with 'tbb'.");
}

void bind_physics(py::class_<SettingsValue>& bound) {
  bound
      .def_property(
          "gravity_mps2", [](const SettingsValue& s) { return tuple_of(s.settings.gravity_mps2); },
          [](SettingsValue& s, const VectorArgument& g) { s.settings.gravity_mps2 = vec3_of("gravity_mps2", g); },
          "Gravity, world frame, m/s^2; (0, 0, 0) by default.")
      .def_property(
          "contact",
          [](const SettingsValue& s) { return std::string(kContacts[static_cast<std::size_t>(s.settings.contact)]); },
          [](SettingsValue& s, const std::string& name) {
            s.settings.contact = static_cast<ContactModel>(index_of("contact", name, kContacts));
          },
          "Contact model: 'fitted', 'wrench' or 'paper' (docs/method.md).")
      .def_property(
          "policy", [](const SettingsValue& s) { return s.policy; },
          [](SettingsValue& s, const py::object& given) { s.policy = policy_of(given, s.policy); },
          "The order of refinement: a Policy (a copy is given and taken), or the name of a kind.")
      .def_property(
          "sleeping", [](const SettingsValue& s) { return s.settings.sleeping; },
          [](SettingsValue& s, bool on) { s.settings.sleeping = on; },
          "Whether islands of bodies that have been still for half a second fall asleep.")
      .def_property(
          "islands_wait",
          [](const SettingsValue& s) { return std::string(kWaits[static_cast<std::size_t>(s.settings.islands_wait)]); },
          [](SettingsValue& s, const std::string& name) {
            s.settings.islands_wait = static_cast<IslandsWait>(index_of("islands_wait", name, kWaits));
          },
          "Which islands may wait in frames that have no time for them: 'any', 'near_rest' or 'never'.")
      .def_property(
          "alpha", [](const SettingsValue& s) { return s.settings.alpha; },
          [](SettingsValue& s, double alpha) { s.settings.alpha = alpha; },
          "Share of frames with a deadline whose end may take longer than its reserve, in [1e-5, 0.5].");
  bind_count(bound, "seed", &WorldSettings::seed, "Of policies that draw random numbers.");
  bind_count(bound, "substeps", &WorldSettings::substeps, "Of the contact solver, 1 to 16.");
  bind_count(bound, "max_partners", &WorldSettings::max_partners, "Most candidate partners of a body, 1 to 65536.");
  bind_count(bound, "max_pairs", &WorldSettings::max_pairs, "Most candidate pairs, 1024 to 2^28.");
  bind_count(bound, "max_front_entries", &WorldSettings::max_front_entries,
             "Capacity for fronts, entries a thread, 64 to 2^26.");
}

}  // namespace

static_assert(simulation::kContactModels[2].name == "fitted" && simulation::kContactModels[0].name == "paper");

SettingsValue::SettingsValue() {
#ifndef POISE_PYTHON_HAVE_TBB
  settings.executor = ExecutorKind::Threads;
#endif
}

void bind_settings(py::module_& module) {
  py::class_<SettingsValue> bound(module, "Settings", R"(Settings of a World, as a value.

Settings(**fields) sets the fields that are named; the others have the library's defaults. Ranges are checked by
what takes the settings: World(...) raises poise.Error with field, value and rule.)");
  bound.def(py::init([](const py::kwargs& fields) {
    auto value = std::make_unique<SettingsValue>();
    set_fields(py::cast(value.get(), py::return_value_policy::reference), fields, "Settings");
    return SettingsValue(*value);
  }));
  bound.def("__repr__", [](const SettingsValue& s) {
    return "poise.Settings(threads=" + std::to_string(s.settings.threads) + ", policy='" + kind_of(s.policy) + "')";
  });
  bind_physics(bound);
  bind_threads(bound);
}

}  // namespace poise::python
