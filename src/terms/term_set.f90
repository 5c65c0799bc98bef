! SPDX-License-Identifier: BSD-3-Clause
!> The definition of the terms theta_t(mu), as data. A term is a function of the parameters mu; loads, gaps and prescribed values
!> are linear functions of the terms.
!>
!> theta_1 = 1. Every other term is a sum of sources. A source is one of three kinds: an expression of the parameters; an expression
!> of the parameters and the coordinates, evaluated at fixed places; the nodal forces of a surface load whose value or window
!> depends on the parameters.
module sig_term_set
  use sig_kinds, only: rk
  use sig_text, only: append_text, string_t
  implicit none(type, external)
  private
  public :: term_set_t, term_source_t, start_terms
  public :: source_expression, source_places, source_surface

  !> kinds of sources, as listed above
  integer, parameter :: source_expression = 1
  integer, parameter :: source_places = 2
  integer, parameter :: source_surface = 3

  !> One source. It adds its values to one or more terms.
  type :: term_source_t
    integer :: kind = source_expression
    !> the expression: of the parameters only for source_expression, otherwise of the parameters and the coordinates
    character(:), allocatable :: text
    !> source_expression: its one term; source_places: the term of each place; source_surface: empty
    integer, allocatable :: terms(:)
    !> [length] coordinates of the places, or of the nodes of the surface, shape (n_dim, n_places)
    real(rk), allocatable :: places(:, :)
    !> source_surface: 0 = pressure, else component of a traction
    integer :: component = 0
    !> number of the coordinate that the window bounds, 0 = no window
    integer :: axis = 0
    !> bounds of the window, expressions of the parameters; empty = no bound
    character(:), allocatable :: minimum
    character(:), allocatable :: maximum
    !> the window cuts facets; otherwise a facet counts as a whole or not at all
    logical :: is_cut = .true.
    !> source_surface: nodes of each facet as indices of `places`, filled up with 0, shape (4 or more, n_facets)
    integer, allocatable :: facets(:, :)
    !> +1 where the order of the facet's nodes gives the outward normal, else -1, shape (n_facets)
    integer, allocatable :: orientations(:)
    !> term of each component of each nodal force, 0 = none, shape (n_dim, n_places)
    integer, allocatable :: dof_terms(:, :)
    !> where the expression stands in the deck, for messages; not kept in a model
    integer :: line = 0
    integer :: column = 0
  end type term_source_t

  !> All terms of a problem or a model.
  type :: term_set_t
    type(string_t), allocatable :: parameter_names(:)
    !> names of the coordinates in expressions: x, y, z or r, z
    type(string_t), allocatable :: coordinate_names(:)
    !> axisymmetric: integrals over surfaces are multiplied by 2 pi times the first coordinate
    logical :: is_round = .false.
    !> a name or the expression for each term, shape (n_terms); the first is `1`
    type(string_t), allocatable :: names(:)
    type(term_source_t), allocatable :: sources(:)
  contains
    procedure :: n_terms
    procedure :: add_term
    procedure :: add_terms
    procedure :: add_expression
    procedure :: add_source
  end type term_set_t

contains

  !> Makes a set that holds only term 1, whose value is always 1. The arguments before `terms` become the components of the same
  !> names.
  pure subroutine start_terms(parameter_names, coordinate_names, is_round, terms)
    type(string_t), intent(in) :: parameter_names(:)
    type(string_t), intent(in) :: coordinate_names(:)
    logical, intent(in) :: is_round
    type(term_set_t), intent(out) :: terms

    terms%parameter_names = parameter_names
    terms%coordinate_names = coordinate_names
    terms%is_round = is_round
    allocate (terms%names(0), terms%sources(0))
    call append_text(terms%names, '1')
  end subroutine start_terms

  !> Returns the number of terms; 0 before start_terms.
  pure integer function n_terms(self)
    class(term_set_t), intent(in) :: self

    n_terms = 0
    if (allocated(self%names)) n_terms = size(self%names)
  end function n_terms

  !> Adds a new term and gives its index. The term is zero until a source adds to it.
  pure subroutine add_term(self, name, i_term)
    class(term_set_t), intent(inout) :: self
    !> a name or the expression, for people
    character(*), intent(in) :: name
    !> 1-based
    integer, intent(out) :: i_term

    call append_text(self%names, name)
    i_term = size(self%names)
  end subroutine add_term

  !> Adds several new terms with one allocation. Each is zero until a source adds to it.
  pure subroutine add_terms(self, names, terms)
    class(term_set_t), intent(inout) :: self
    !> a name or the expression of each, for people
    type(string_t), intent(in) :: names(:)
    !> indices of the new terms, 1-based, shape (size(names))
    integer, intent(out) :: terms(:)
    type(string_t), allocatable :: longer(:)
    integer :: i, n

    n = size(self%names)
    allocate (longer(n + size(names)))
    longer(:n) = self%names
    longer(n + 1:) = names
    call move_alloc(longer, self%names)
    terms = [(n + i, i=1, size(names))]
  end subroutine add_terms

  !> Adds a new term that is an expression of the parameters, and gives its index (i_term, 1-based). The text is not checked here.
  pure subroutine add_expression(self, text, line, column, i_term)
    class(term_set_t), intent(inout) :: self
    !> the expression, which becomes the name of the term, too
    character(*), intent(in) :: text
    !> line and column of the text in the deck, for messages
    integer, intent(in) :: line
    integer, intent(in) :: column
    integer, intent(out) :: i_term
    type(term_source_t) :: source

    call self%add_term(text, i_term)
    source%text = text
    source%terms = [i_term]
    source%line = line
    source%column = column
    call self%add_source(source)
  end subroutine add_expression

  !> Adds a copy of a source, whose text must be set and whose terms must exist. Other components of the copy that are not allocated
  !> become empty.
  pure subroutine add_source(self, source)
    class(term_set_t), intent(inout) :: self
    type(term_source_t), intent(in) :: source
    type(term_source_t), allocatable :: longer(:)
    integer :: i, n

    n = size(self%sources)
    allocate (longer(n + 1))
    do i = 1, n
      call move_source(self%sources(i), longer(i))
    end do
    longer(n + 1) = source
    associate (whole => longer(n + 1))
      if (.not. allocated(whole%terms)) allocate (whole%terms(0))
      if (.not. allocated(whole%places)) allocate (whole%places(size(self%coordinate_names), 0))
      if (.not. allocated(whole%minimum)) whole%minimum = ''
      if (.not. allocated(whole%maximum)) whole%maximum = ''
      if (.not. allocated(whole%facets)) allocate (whole%facets(4, 0))
      if (.not. allocated(whole%orientations)) allocate (whole%orientations(0))
      if (.not. allocated(whole%dof_terms)) allocate (whole%dof_terms(size(self%coordinate_names), 0))
    end associate
    call move_alloc(longer, self%sources)
  end subroutine add_source

  !> Moves a source without copying its arrays, because a deck may have thousands of sources.
  pure subroutine move_source(from, to)
    type(term_source_t), intent(inout) :: from
    type(term_source_t), intent(inout) :: to

    to%kind = from%kind
    to%component = from%component
    to%axis = from%axis
    to%is_cut = from%is_cut
    to%line = from%line
    to%column = from%column
    call move_alloc(from%text, to%text)
    call move_alloc(from%terms, to%terms)
    call move_alloc(from%places, to%places)
    call move_alloc(from%minimum, to%minimum)
    call move_alloc(from%maximum, to%maximum)
    call move_alloc(from%facets, to%facets)
    call move_alloc(from%orientations, to%orientations)
    call move_alloc(from%dof_terms, to%dof_terms)
  end subroutine move_source
end module sig_term_set
