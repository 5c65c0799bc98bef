! SPDX-License-Identifier: BSD-3-Clause
!> Answer of a contact solver for one parameter point: pure data, the same on every rank.
module sig_contact_state
  use sig_flowing_cells, only: flow_work_t
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: contact_state_t, flow_answer_t, residuals_t

  !> How well (3) is met. All but the penetration are relative to the size of what they compare.
  type :: residuals_t
    !> [-] largest entry of K u + B' lambda - F on the free dofs, over the largest of: the entries of K u and of B' lambda, 1e-6 of
    !> |K| |u|, and 1e-6 of the largest load on a dof, the parts of which are added without sign
    real(rk) :: equilibrium = 0
    !> [length] largest B u - D, 0 where nothing penetrates
    real(rk) :: penetration = 0
    !> [-] largest -lambda_n, with friction also |lambda_t| - f lambda_n, over the largest |lambda|; 0 where neither is positive
    real(rk) :: negative_multiplier = 0
    !> [-] over the largest |lambda| times the largest of |D| and |u|: |lambda . (D - B u)| of the normal forces; with friction also
    !> the sum of f lambda_n |slip| - lambda_t . slip, 0 where forces act along the slip
    real(rk) :: complementarity = 0
    !> [-] resultant of reactions, loads and obstacles over the sum of the sizes of reactions and loads (or over the larger 1e-6 in
    !> `equilibrium`, if this is more), worst component; in axisymmetry only along z
    real(rk) :: force_balance = 0
  end type residuals_t

  !> What a state has besides where materials flow (plasticity, creep).
  type :: flow_answer_t
    !> [-] strains, shears as angles, and behind them the accumulated equivalent strain, at the integration points of all cells that
    !> flow; shape (7, n_points), not allocated without an answer
    real(rk), allocatable :: plastic(:, :)
    real(rk), allocatable :: creep(:, :)
    !> [-] share of the points of each material whose plastic strain grew in the last step that was tried, shape (n_materials)
    real(rk), allocatable :: yielding(:)
    !> [-] residual of equilibrium behind each step of Newton's method, at the end of the time
    real(rk), allocatable :: residuals(:)
    type(flow_work_t) :: work
    !> [-] by how much the balance of work is missed, relative to the sum of the sizes of its terms
    real(rk) :: work_residual = 0
    !> how often a step was cut in two since the last time
    integer :: n_cuts = 0
    !> [time] up to which there is an answer, if there is none at the state's own time
    real(rk) :: reached = 0
  end type flow_answer_t

  !> An answer, or the reason why there is none.
  type :: contact_state_t
    !> [length] natural, shape (n_dofs)
    real(rk), allocatable :: displacement(:)
    !> [force] normal forces, >= 0 if not tied, then tangential forces; shape (n_rows)
    real(rk), allocatable :: multipliers(:)
    !> [length] slip since the last time, in tangential rows; 0 where a contact sticks, or opens; shape (n_rows), not allocated
    !> without friction
    real(rk), allocatable :: slip(:)
    !> [length] place of tangential rows from which their slip counts: B_t u at the last time; shape (n_rows), not allocated without
    !> friction
    real(rk), allocatable :: origins(:)
    !> [-] coefficients of friction, shape (n_contacts), not allocated without friction
    real(rk), allocatable :: friction(:)
    !> whether each contact slips, shape (n_contacts), not allocated without friction
    logical, allocatable :: slips(:)
    !> without an equilibrium: amplitudes of the free motion in which bodies slide or come off, up to a factor; shape (n_free), else
    !> not allocated
    real(rk), allocatable :: drift(:)
    !> number of solutions that were found: with large coefficients of friction there may be several; 0: they were not counted
    integer :: n_solutions = 1
    !> [force] forces of the supports on the prescribed dofs, 0 elsewhere; shape (n_dofs). Not set by measure_points
    real(rk), allocatable :: reactions(:)
    !> [force*length] u . K u / 2, the elastic energy where no strains are imposed
    real(rk) :: energy = 0
    !> whether each row may carry a force: its contact is closed; shape (n_rows)
    logical, allocatable :: is_active(:)
    !> number of steps of the contact solver; where materials flow, of Newton's method
    integer :: n_iterations = 0
    !> number of iterations of conjugate gradients in all these steps; 0 if the matrix is factorized
    integer :: n_linear_iterations = 0
    !> > 0 solved, < 0 failed: one of sig_reasons
    integer :: reason = 0
    type(residuals_t) :: residuals
    !> [s] wall time of the solve
    real(rk) :: seconds = 0
    !> not allocated where no material flows
    type(flow_answer_t), allocatable :: flow
  contains
    procedure :: normal_forces
  end type contact_state_t

contains

  !> Returns the normal forces [force] of all contacts, shape (n_contacts).
  pure function normal_forces(self) result(forces)
    class(contact_state_t), intent(in) :: self
    real(rk), allocatable :: forces(:)

    if (allocated(self%friction)) then
      forces = self%multipliers(:size(self%friction))
    else
      forces = self%multipliers
    end if
  end function normal_forces
end module sig_contact_state
