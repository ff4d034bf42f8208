// SPDX-License-Identifier: MIT
#include <string>

#include "poise/scheduler/cues.h"
#include "poise/scheduler/problem.h"
#include "scene/policy_file.h"
#include "scene/run/policy_name.h"
#include "settings.h"

namespace poise::python {
namespace {

using scheduler::Policy;

void set_kind(PolicyValue& value, const std::string& name) {
  if (name == "custom") {
    value.policy.kind = scheduler::PolicyKind::Custom;
    return;
  }
  value.policy.kind = io::kPolicies[index_of("kind", name, io::kPolicyNames)].kind;
}

/// Sets a member and takes it back if the policy is then refused for it.
template <class T>
void set_number(PolicyValue& value, T Policy::*member, T number) {
  const T before = value.policy.*member;
  value.policy.*member = number;
  // The function of the kind `custom` may be set later.
  Policy probe = value.policy;
  if (probe.kind == scheduler::PolicyKind::Custom) probe.kind = scheduler::PolicyKind::Perceptual;
  if (const auto problem = scheduler::first_problem(probe)) {
    value.policy.*member = before;
    raise(bad_input("policy." + scheduler::text_of(*problem)));
  }
}

void set_function(py::object& member, const char* name, const py::object& function) {
  if (!function.is_none() && PyCallable_Check(function.ptr()) == 0)
    raise(
        bad_input(std::string(name) + " = " + py::repr(function).cast<std::string>() + ", must be a function or None"));
  member = function;
}

std::string doc_of(const scheduler::PolicyField& field) {
  std::string doc = "In [" + py::repr(py::float_(field.least)).cast<std::string>() + ", " +
                    py::repr(py::float_(field.most)).cast<std::string>() + "]";
  for (const scheduler::Cue* cue : scheduler::cue_list()) {
    if (cue->name == field.name) return "Weight of the cue, measured in " + std::string(cue->unit) + ". " + doc + ".";
  }
  return "Parameter. " + doc + "; docs/cues.md says of what.";
}

void bind_numbers(py::class_<PolicyValue>& bound) {
  const auto real = [&bound](const scheduler::PolicyField& field) {
    double Policy::*const member = field.value;
    bound.def_property(
        std::string(field.name).c_str(), [member](const PolicyValue& p) { return p.policy.*member; },
        [member](PolicyValue& p, double number) { set_number(p, member, number); }, doc_of(field).c_str());
  };
  for (const scheduler::PolicyField& field : scheduler::policy_weights()) real(field);
  for (const scheduler::PolicyField& field : scheduler::policy_parameters()) real(field);
  for (const scheduler::PolicyCount& field : scheduler::policy_counts()) {
    std::uint32_t Policy::*const member = field.value;
    const std::string name(field.name);
    bound.def_property(
        name.c_str(), [member](const PolicyValue& p) { return p.policy.*member; },
        [member, name](PolicyValue& p, const py::object& number) {
          set_number(p, member, static_cast<std::uint32_t>(whole_of(name.c_str(), number, 0xffffffffU)));
        },
        ("Parameter, a whole number in [" + std::to_string(field.least) + ", " + std::to_string(field.most) + "].")
            .c_str());
  }
}

}  // namespace

std::string kind_of(const PolicyValue& policy) { return io::policy_name(policy.policy.kind); }

PolicyValue policy_of(const py::object& given, const PolicyValue& base) {
  if (py::isinstance<PolicyValue>(given)) return given.cast<PolicyValue>();
  if (!py::isinstance<py::str>(given))
    throw py::type_error("policy must be a poise.Policy or the name of a kind, not " +
                         py::repr(given).cast<std::string>());
  PolicyValue named = base;
  set_kind(named, given.cast<std::string>());
  return named;
}

void check_policy(const PolicyValue& policy) {
  Policy probe = policy.policy;
  if (!policy.custom.is_none()) {
    probe.custom.function = [](const scheduler::FrameFacts&, const scheduler::PairChain&, const scheduler::PairCues&,
                               void*) noexcept { return 0.0; };
  }
  if (const auto problem = scheduler::first_problem(probe)) raise(bad_input("policy." + scheduler::text_of(*problem)));
}

void bind_policy(py::module_& module) {
  py::class_<PolicyValue> bound(
      module, "Policy",
      R"(How the next refinement is chosen: a rule, weights of cues, parameters, and functions in Python.

Policy(kind='perceptual', **fields) sets the fields that are named; the others have the library's defaults. Each
cue is a factor of a pair's score, raised to its weight; weight 0 turns it off (docs/cues.md). A number out of
range raises poise.Error with the field. A Policy is a value: changing one that was given to a World changes
nothing there.)");
  bound
      .def(py::init([](const std::string& kind, const py::kwargs& fields) {
             auto value = std::make_unique<PolicyValue>();
             set_kind(*value, kind);
             const py::object self = py::cast(value.get(), py::return_value_policy::reference);
             set_fields(self, fields, "Policy");
             return PolicyValue(*value);
           }),
           py::arg("kind") = "perceptual")
      .def_static(
          "from_file",
          [](const py::object& path) {
            const auto name = py::module_::import("os").attr("fspath")(path).cast<std::string>();
            return PolicyValue{taken(io::read_policy_file(name, Policy{})).policy};
          },
          py::arg("path"), "The policy of a file of the schema poise.policy/1, e.g. of `poise tune`.")
      .def_property("kind", &kind_of, &set_kind,
                    "The rule: perceptual, fifo, random, round-robin, size, deepest, equal-levels or custom.")
      .def_property(
          "cue", [](const PolicyValue& p) { return p.cue; },
          [](PolicyValue& p, const py::object& f) { set_function(p.cue, "cue", f); },
          R"(A cue in Python, or None: a function of a PairView that returns a factor of the pair's score, in [0, 1e6].

1 changes nothing, 0 is the lowest priority; it is raised to the weight `host`. Called in steps with a budget,
for each pair that is ranked. It must not use the World, and its result must depend on its argument alone.

SLOW: a call takes about a microsecond and holds the global lock, so the step's threads wait for one another:
measure first (docs/python.md has figures). An exception ends the use of the function for that step, and
World.step raises it when the step is done.)")
      .def_property(
          "custom", [](const PolicyValue& p) { return p.custom; },
          [](PolicyValue& p, const py::object& f) { set_function(p.custom, "custom", f); },
          R"(A policy in Python, or None: (FrameFacts, PairChain, PairCues) -> score; the larger, the sooner.

Used if `kind` is 'custom', which needs it. Called for each pair that enters the queue: before refinement, and
after each level. As slow as `cue`, and with the same rules.)")
      .def("__repr__", [](const PolicyValue& p) { return "poise.Policy(kind='" + kind_of(p) + "')"; });
  bind_numbers(bound);
}

}  // namespace poise::python
