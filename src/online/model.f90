! SPDX-License-Identifier: BSD-3-Clause
!> A trained model as data: everything that a query or a description needs. Nothing here depends on a mesh file or a deck.
module sig_model
  use sig_contact_laws, only: contact_laws_t, laws_without_friction
  use sig_field_map, only: field_map_t
  use sig_history, only: history_t
  use sig_idle_work, only: idle_work_t
  use sig_kinds, only: rk
  use sig_missing_parts, only: fill_missing
  use sig_model_choice, only: model_choice_t
  use sig_model_data, only: model_sizes_t
  use sig_term_set, only: start_terms, term_set_t
  use sig_reduced, only: part_t
  use sig_resultant_map, only: resultant_map_t
  use sig_text, only: string_t, to_text
  implicit none(type, external)
  private
  public :: model_t, contact_side_t, validation_statistics_t, complete_model, model_sizes

  !> version of the file layout; it increases when an older reader would misread the file (5: displacements of condensed parts
  !> in the norm of the stiffness; 7: friction)
  integer, parameter, public :: model_format_version = 7
  !> oldest layout that can be read
  integer, parameter, public :: oldest_model_format = 6

  !> Nodes of one side of all contacts; the nodes of contact k are starts(k) + 1 ... starts(k + 1).
  type :: contact_side_t
    !> shape (n_contacts + 1)
    integer, allocatable :: starts(:)
    !> tags of the mesh file; on the first side the node that carries the contact's force comes first
    integer, allocatable :: tags(:)
    !> [-] share of the contact's force on each node, shape (size(tags))
    real(rk), allocatable :: weights(:)
    !> [length] shape (n_dim, size(tags))
    real(rk), allocatable :: coordinates(:, :)
  contains
    procedure :: owner_tag
  end type contact_side_t

  !> Errors against the full-order model over a test set; empty until validated.
  type :: validation_statistics_t
    !> sentence that says whether the errors are small enough; empty until validated
    character(:), allocatable :: verdict
    !> names of the errors: e_u, e_lambda_rid, ...; minimum, median, p95 and maximum have a value for each name
    type(string_t), allocatable :: names(:)
    real(rk), allocatable :: minimum(:)
    real(rk), allocatable :: median(:)
    real(rk), allocatable :: p95(:)
    real(rk), allocatable :: maximum(:)
    !> methods, and how many of the points each one answered, `none` included; empty until validated
    type(string_t), allocatable :: method_names(:)
    integer, allocatable :: method_counts(:)
  end type validation_statistics_t

  !> A whole model: the header, the choice, and the parts.
  type :: model_t
    integer :: format_version = model_format_version
    character(:), allocatable :: code_version
    !> deck with all defaults, for people
    character(:), allocatable :: deck_text
    character(:), allocatable :: title
    !> hash of physics and mesh, the same as in the snapshots
    character(:), allocatable :: provenance
    character(:), allocatable :: mesh_hash
    character(:), allocatable :: length_unit
    character(:), allocatable :: force_unit
    !> names of the numbers of a state: the parameters and, with a history, behind them the time and its tables
    type(string_t), allocatable :: parameter_names(:)
    type(string_t), allocatable :: parameter_units(:)
    !> [unit of each parameter] minimum and maximum of each parameter in training, shape (2, n_parameters)
    real(rk), allocatable :: box(:, :)
    !> [unit of each parameter] shape (n_parameters, n_points)
    real(rk), allocatable :: training_points(:, :)
    !> times and tables; none of both if the deck has no history
    type(history_t) :: history
    !> the terms theta as functions of the parameters
    type(term_set_t) :: terms
    integer :: n_nodes = 0
    integer :: n_dofs = 0
    integer :: n_dim = 0
    !> number of all contact forces: normal ones, one per contact, then tangential ones
    integer :: n_multipliers = 0
    !> friction, and ties
    type(contact_laws_t) :: laws
    !> node tags of the mesh file, shape (n_nodes), or none
    integer, allocatable :: node_tags(:)
    !> [length] shape (n_dim, n_nodes), or none
    real(rk), allocatable :: coordinates(:, :)
    !> nodes of the side that carries the forces, at least one per contact: the first surface of the entry in the deck, or the
    !> second one where rows of mortar contact belong to it
    type(contact_side_t) :: first_side
    !> nodes of the other side; a contact with a rigid obstacle has none
    type(contact_side_t) :: second_side
    !> [length**2, length in the plane] pressure = normal force / area, 0 in rows of tangential forces; shape (n_multipliers)
    real(rk), allocatable :: areas(:)
    !> sums of the contact forces over each entry of the deck's contact section
    type(resultant_map_t) :: resultants
    !> [length per unit of theta] initial gaps of all contacts, shape (n_multipliers, n_terms)
    real(rk), allocatable :: gap(:, :)
    !> work of the loads on motions that nothing holds; no motions if it is zero term by term
    type(idle_work_t) :: idle_work
    !> [-] energy tail of the POD
    real(rk) :: pod_tolerance = 0
    !> elastic_lifting or multiplier: how the reduced model takes prescribed displacements into account (key reduction.dirichlet)
    character(:), allocatable :: dirichlet
    !> [-] largest allowed relative bound of a cluster's answer. If the bound is larger, the fallback answers; without a fallback
    !> the point has no answer. With 0 there is no limit, and the fallback does not bound the errors of clusters
    real(rk) :: max_error = 0
    !> one per cluster, then the fallback if there is one
    type(part_t), allocatable :: parts(:)
    logical :: has_fallback = .false.
    !> choice of the cluster that answers at a point; empty with one cluster
    type(model_choice_t) :: choice
    type(validation_statistics_t) :: validation
    !> data for fields; empty where the deck did not ask for them
    type(field_map_t) :: fields
  contains
    procedure :: remembers
    procedure :: has_estimates
    procedure :: n_given
    procedure :: i_time
    procedure :: n_clusters
    procedure :: fallback
    procedure :: group_of
  end type model_t

contains

  !> Allocates with size 0 each text and array of the model and of its parts that is not allocated, except in `choice` and `fields`.
  !> Missing contact sides have no nodes. A missing set of terms gets one term, the constant 1.
  pure subroutine complete_model(model)
    type(model_t), intent(inout) :: model
    integer :: i

    call fill_missing(model%code_version)
    call fill_missing(model%deck_text)
    call fill_missing(model%title)
    call fill_missing(model%provenance)
    call fill_missing(model%mesh_hash)
    call fill_missing(model%length_unit)
    call fill_missing(model%force_unit)
    call fill_missing(model%dirichlet)
    call fill_missing(model%parameter_names)
    call fill_missing(model%parameter_units)
    call fill_missing(model%box, 2)
    call fill_missing(model%history%unit)
    if (.not. allocated(model%history%times)) allocate (model%history%times(0))
    if (.not. allocated(model%history%tables)) allocate (model%history%tables(0))
    call fill_missing(model%training_points, size(model%parameter_names))
    if (model%terms%n_terms() == 0) call start_terms(model%parameter_names, [string_t ::], .false., model%terms)
    call fill_missing(model%node_tags)
    call fill_missing(model%coordinates, model%n_dim)
    if (.not. allocated(model%laws%tangents)) model%laws = laws_without_friction(model%n_multipliers)
    call complete_side(model%first_side, model%n_dim, model%laws%n_contacts)
    call complete_side(model%second_side, model%n_dim, model%laws%n_contacts)
    call fill_missing(model%areas)
    call model%resultants%complete(model%n_dim)
    call fill_missing(model%gap, model%n_multipliers)
    call fill_missing(model%idle_work%work, model%terms%n_terms())
    call fill_missing(model%idle_work%limits, model%terms%n_terms())
    call fill_missing(model%validation%verdict)
    call fill_missing(model%validation%names)
    call fill_missing(model%validation%minimum)
    call fill_missing(model%validation%median)
    call fill_missing(model%validation%p95)
    call fill_missing(model%validation%maximum)
    call fill_missing(model%validation%method_names)
    call fill_missing(model%validation%method_counts)
    if (.not. allocated(model%parts)) allocate (model%parts(0))
    do i = 1, size(model%parts)
      call model%parts(i)%reduced%complete(model_sizes(model))
    end do
  end subroutine complete_model

  pure subroutine complete_side(side, n_dim, n_contacts)
    type(contact_side_t), intent(inout) :: side
    integer, intent(in) :: n_dim
    integer, intent(in) :: n_contacts

    if (.not. allocated(side%starts)) allocate (side%starts(n_contacts + 1), source=0)
    call fill_missing(side%tags)
    call fill_missing(side%weights)
    call fill_missing(side%coordinates, n_dim)
  end subroutine complete_side

  !> Returns the numbers of dofs, multipliers, terms and training points of a model, which its parts have to fit. Requires: training
  !> points and terms are set.
  pure function model_sizes(model) result(sizes)
    type(model_t), intent(in) :: model
    type(model_sizes_t) :: sizes

    sizes = model_sizes_t(n_dofs=model%n_dofs, n_multipliers=model%n_multipliers, n_terms=model%terms%n_terms(), laws=model%laws, &
      n_points=size(model%training_points, 2))
  end function model_sizes

  !> Returns the tag of the node on the first side that carries the force of contact k. Requires: self is the first side.
  pure integer function owner_tag(self, k)
    class(contact_side_t), intent(in) :: self
    !> number of the contact, 1-based
    integer, intent(in) :: k

    owner_tag = self%tags(self%starts(k) + 1)
  end function owner_tag

  !> Whether the answer at a state depends on the states before it: contacts have friction, or materials flow.
  pure logical function remembers(self)
    class(model_t), intent(in) :: self

    remembers = self%laws%remembers() .or. self%has_estimates()
  end function remembers

  !> Whether answers have an error_estimate: materials flow.
  pure logical function has_estimates(self)
    class(model_t), intent(in) :: self
    integer :: i

    has_estimates = .false.
    if (.not. allocated(self%parts)) return
    do i = 1, size(self%parts)
      has_estimates = has_estimates .or. self%parts(i)%reduced%remembers()
    end do
  end function has_estimates

  !> Returns the number of parameters that a user gives: without the time and the tables of a history.
  pure integer function n_given(self)
    class(model_t), intent(in) :: self

    n_given = size(self%parameter_names) - self%history%n_values()
  end function n_given

  !> Returns the number of the time among the numbers of a state, 1-based; 0 without a history.
  pure integer function i_time(self)
    class(model_t), intent(in) :: self

    i_time = 0
    if (self%history%is_there()) i_time = self%n_given() + 1
  end function i_time

  !> Returns the number of parts among which the choice selects: all parts but the fallback; 0 if there are no parts yet.
  pure integer function n_clusters(self)
    class(model_t), intent(in) :: self

    n_clusters = 0
    if (allocated(self%parts)) n_clusters = size(self%parts) - merge(1, 0, self%has_fallback)
  end function n_clusters

  !> Returns the number (1-based) of the part that answers where a cluster cannot; 0 if the model has no fallback.
  pure integer function fallback(self)
    class(model_t), intent(in) :: self

    fallback = merge(self%n_clusters() + 1, 0, self%has_fallback)
  end function fallback

  !> Returns the name of the group of part i in the model file, without a leading slash: `clusters/i` or `fallback`.
  pure function group_of(self, i) result(group)
    class(model_t), intent(in) :: self
    !> number of the part, 1-based
    integer, intent(in) :: i
    character(:), allocatable :: group

    group = 'fallback'
    if (i <= self%n_clusters()) group = 'clusters/' // to_text(i)
  end function group_of
end module sig_model
