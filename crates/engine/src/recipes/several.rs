//! Plans of several products, or with least time, energy or transfers, and why there is none.

use super::causes;
use super::findings::Subject;
use super::words::{self, quoted};
use super::{Aim, Decision, Solution, attempt, search_limits};
use crate::internal::Fault;
use crate::pipeline::Verdict;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::recipe::{Layout, Realization, Recipe};
use linewright_recipe::model::{Demand, Problem};
use linewright_recipe::plan::{Execution, MAX_TOGETHER, Method, PlanLimits, PlanOutcome, plan};
use linewright_recipe::realize::{Obstacle, Outcome};
use linewright_solver::game::BudgetFactor;

/// What is to be made, with its models.
#[derive(Debug, Clone, Copy)]
pub(super) struct Order<'m> {
    pub layout: &'m Layout,
    /// The recipe of each demand.
    pub recipes: &'m [&'m Recipe],
    pub realization: &'m Realization,
}

impl<'m> Order<'m> {
    fn demands(&self) -> Vec<Demand> {
        let wanted = self.realization.recipes.iter().zip(self.recipes);
        let demand = wanted.map(|(wanted, recipe)| {
            let count = usize::try_from(wanted.count).unwrap_or(usize::MAX);
            Demand::new(recipe.model.clone(), count)
        });
        demand.collect()
    }

    fn subject(&self, demand: usize) -> Subject<'m> {
        Subject {
            layout: self.layout,
            recipe: self.recipes[demand],
            realization: self.realization,
        }
    }

    fn names(&self) -> String {
        quoted(self.recipes.iter().map(|r| r.model.name.as_str()))
    }
}

/// Returns the limits of planning: those of the crate `recipe` times the factor. As each node of
/// the search over all plans takes time for each product, there are fewer of them.
fn limits(factor: BudgetFactor, products: usize, first: bool) -> PlanLimits {
    let scaled = |count: usize| usize::try_from(factor.scale(count as u64)).unwrap_or(usize::MAX);
    let PlanLimits {
        nodes,
        together,
        job_shop,
        ..
    } = PlanLimits::default();
    PlanLimits {
        nodes: scaled(nodes),
        together: scaled(together) / products.max(1),
        job_shop,
        first,
    }
}

/// Plans the products, and names the causes if they cannot be made. The plan has passed its replay.
///
/// # Errors
/// The models have problems that the resolver should have reported.
pub(super) fn decide(order: &Order<'_>, aim: Aim, first: bool) -> Result<Decision, Fault> {
    let demands = order.demands();
    let products = demands.iter().map(|d| d.count).sum();
    let limits = limits(aim.factor, products, first);
    let outcome = match plan(&order.layout.model, &demands, aim.objective, limits) {
        Ok(outcome) => outcome,
        Err(problems) => return too_large(order, &problems),
    };
    let (verdict, findings) = match outcome {
        PlanOutcome::Planned(plan) => return Ok(Decision::realizable(Solution::Plan(plan))),
        PlanOutcome::Unrealizable { obstacles, .. } if !obstacles.is_empty() => {
            (Verdict::Unrealizable, of_obstacles(order, &obstacles))
        }
        PlanOutcome::Unrealizable { .. } => {
            let alone = alone(order, aim)?;
            let found = if alone.causes.is_empty() {
                vec![not_together(
                    order,
                    aim,
                    &demands,
                    limits,
                    alone.is_complete,
                )]
            } else {
                alone.causes
            };
            (Verdict::Unrealizable, found)
        }
        PlanOutcome::GaveUp { nodes, tried } => {
            let cause = alone(order, aim)?.causes.into_iter().next();
            let found = gave_up(order, products, nodes, &tried, cause.as_ref());
            (Verdict::GaveUp, vec![found])
        }
    };
    Ok(Decision::without_solution(verdict, findings))
}

/// The causes that were found without a search, at the recipes that they concern.
fn of_obstacles(order: &Order<'_>, obstacles: &[(usize, Obstacle)]) -> Vec<Diagnostic> {
    let found = obstacles
        .iter()
        .map(|(demand, obstacle)| order.subject(*demand).finding(obstacle));
    found.collect()
}

/// What is known of each recipe on its own.
struct Alone {
    /// Why one product of some recipes cannot be made alone, step by step.
    causes: Vec<Diagnostic>,
    /// Whether this was decided for all recipes.
    is_complete: bool,
}

fn alone(order: &Order<'_>, aim: Aim) -> Result<Alone, Fault> {
    let limits = search_limits(aim.factor);
    let mut found = Alone {
        causes: Vec::new(),
        is_complete: true,
    };
    for (demand, recipe) in order.recipes.iter().enumerate() {
        match attempt(order.layout, recipe, aim.factor)? {
            Outcome::Realizable(_) => {}
            Outcome::Unrealizable(refusal) => {
                let causes = causes::find(&order.subject(demand), &refusal, limits);
                found.causes.extend(causes);
            }
            Outcome::GaveUp(_) => found.is_complete = false,
        }
    }
    Ok(found)
}

/// The finding for products of which no cause was found alone.
fn not_together(
    order: &Order<'_>,
    aim: Aim,
    demands: &[Demand],
    limits: PlanLimits,
    is_alone_known: bool,
) -> Diagnostic {
    let title = words::title(order.realization);
    let error = |message: String, help: &str| {
        Diagnostic::error(codes::RECIPE_UNREALIZABLE, order.realization.span, message)
            .with_help(help)
    };
    let makes = |demand: Demand| {
        let outcome = plan(
            &order.layout.model,
            &[demand],
            aim.objective,
            PlanLimits {
                first: true,
                ..limits
            },
        );
        matches!(outcome, Ok(PlanOutcome::Planned(_)))
    };
    let one = |demand: &Demand| Demand::new(demand.recipe.clone(), 1);
    let is_timed = aim.objective.execution() == Execution::Timed;
    let late = demands.iter().find(|d| is_timed && !makes(one(d)));
    if let Some(demand) = late.filter(|_| is_alone_known) {
        let message = format!(
            "{title} cannot be made with these times, though `{}` can be made step by step",
            demand.recipe.name
        );
        let help = "a resource would have to wait where it may not: let it wait there with `nop`, or change the times";
        return error(message, help);
    }
    let reasons = "parts that remain, stock that is used up, and resources that do not come back to their first state can be the reason";
    if !is_alone_known {
        return error(format!("{title} cannot be made"), reasons);
    }
    let most = match demands {
        [demand] => {
            let more = 2..demand.count.min(MAX_TOGETHER);
            let count = more.take_while(|n| makes(Demand::new(demand.recipe.clone(), *n)));
            format!(
                "{} can be made, but no plan makes them all",
                count.last().unwrap_or(1)
            )
        }
        _ => format!(
            "a product of each of {} can be made alone, but no plan makes them all",
            order.names()
        ),
    };
    error(format!("{title} cannot be made: {most}"), reasons)
}

fn gave_up(
    order: &Order<'_>,
    products: usize,
    nodes: usize,
    tried: &[Method],
    cause: Option<&Diagnostic>,
) -> Diagnostic {
    let mut steps: Vec<String> = Vec::new();
    for method in tried {
        match method {
            Method::OneAfterTheOther(_) => {
                steps.push("no plan makes one product after the other".to_owned());
            }
            Method::JobShop => {
                steps.push("the order of the schedule with ample buffers does not fit".to_owned());
            }
            Method::Search => {}
        }
    }
    steps.push(if products > MAX_TOGETHER {
        format!("more than {MAX_TOGETHER} products are not searched together")
    } else {
        format!("the search over all plans ended at {nodes} nodes")
    });
    let help = match cause {
        Some(cause) => format!("alone, one of them cannot be made: {}", cause.message),
        None => "`--effort 10` lets it try ten times as many; or ask for fewer products".to_owned(),
    };
    undecided(order, &steps.join("; "), help)
}

fn undecided(order: &Order<'_>, why: &str, help: String) -> Diagnostic {
    let title = words::title(order.realization);
    let message = format!("it is not decided whether {title} can be made: {why}");
    Diagnostic::warning(codes::RECIPE_UNDECIDED, order.realization.span, message)
        .with_help(help)
        .giving_up(true)
}

/// The decision if the products or their quantities are beyond the limits of planning.
fn too_large(order: &Order<'_>, problems: &[Problem]) -> Result<Decision, Fault> {
    let errors = || problems.iter().filter(|p| !p.is_warning());
    let is_limit = |p: &Problem| matches!(p, Problem::TooLarge { .. });
    let Some(first) = errors().next().filter(|_| errors().all(is_limit)) else {
        let problems: Vec<String> = problems.iter().map(ToString::to_string).collect();
        let doing = format!("planning {}", words::title(order.realization));
        return Err(Fault::detected(doing, problems.join("; ")));
    };
    let is_count = matches!(first, Problem::TooLarge { what, .. } if what.starts_with("products"));
    let help = if is_count {
        "ask for fewer products in each statement"
    } else {
        "write shorter times and less power in the layout"
    };
    let found = undecided(order, &first.to_string(), help.to_owned());
    Ok(Decision::without_solution(Verdict::GaveUp, vec![found]))
}
